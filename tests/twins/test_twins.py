"""Every GLSL library function against its float64 twin, over the domain of its parameters with the corners."""

import importlib

import domains
import numpy as np
import pytest
import twin

from glcloth.files import GLSL

FOLDERS = ("core", "fibre", "sg", "direct", "woven", "trace", "simulate")
CASES = [
    pytest.param(path.relative_to(GLSL).as_posix(), name, id=f"{path.parent.name}/{path.stem}:{name}")
    for folder in FOLDERS
    for path in sorted((GLSL / folder).glob("*.glsl"))
    for name in twin.functions(path.relative_to(GLSL))
]


def described(path):
    """The domains module of a GLSL file's folder."""
    try:
        return importlib.import_module(f"domains.{path.split('/')[0]}")
    except ModuleNotFoundError:
        return domains


def arguments(path, name, parameters, count, rng):
    """Rounded to float32, so that both sides see the same numbers."""
    own = described(path)
    special, general = getattr(own, "SPECIAL", {}), {**domains.DOMAINS, **getattr(own, "DOMAINS", {})}
    together = getattr(own, "JOINT", {}).get(name, lambda *_: {})(rng, count)
    out = []
    for kind, parameter in parameters:
        domain = special.get((name, parameter)) or general.get(parameter)
        assert domain is not None or parameter in together, (
            f"{name}: give `{kind} {parameter}` a domain in tests/domains/{path.split('/')[0]}.py"
        )
        values = np.asarray(together[parameter] if parameter in together else domain(rng, count))
        out.append(values if kind[0] in "iu" else values.astype(np.float32).astype(np.float64))
    return out


@pytest.mark.parametrize(("path", "name"), CASES)
def test_twin(ctx, path, name):
    _, parameters = twin.functions(path)[name]
    reference = getattr(importlib.import_module(f"glcloth.twins.{path.split('/')[-1].removesuffix('.glsl')}"), name)
    args = arguments(path, name, parameters, 10_000, np.random.default_rng(7))
    got = twin.call(ctx, path, name, *args)
    expected = np.asarray(reference(*args))
    if name in getattr(described(path), "PACKED", ()):  # GPUs round the last bit of a 16-bit float as they like
        got, expected = (np.ascontiguousarray(values, "<u4").view("<u2").astype(float) for values in (got, expected))
    assert np.isfinite(expected).all(), "the twin itself is not finite: is the domain right?"
    rtol, atol = getattr(described(path), "TOLERANCE", {}).get(name, (domains.RTOL, domains.ATOL))
    error = np.abs(got - expected) - atol - rtol * np.abs(expected)
    worst = np.unravel_index(np.argmax(np.where(np.isfinite(error), error, np.inf)), error.shape)
    where = ", ".join(f"{p} = {a[worst[0]]}" for (_, p), a in zip(parameters, args, strict=True))
    assert np.isfinite(got).all() and error[worst] <= 0, f"{name}({where}) = {got[worst[0]]}, twin {expected[worst[0]]}"
