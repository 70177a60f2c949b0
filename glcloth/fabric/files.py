"""Fabrics in files: TOML, and weavers' drafts."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import InputError, meant
from ..files import PACKAGE, atomic_write, path_of, read_toml
from ..progress import warn
from ..weave.model import Weave
from ..weave.others import is_draft
from .fabric import Fabric, derived_names

if TYPE_CHECKING:
    from ..weave.draft import Draft

FABRICS = PACKAGE / "fabrics"


def draft_fabric(draft: Draft, name: str | None = None) -> Fabric:
    """A fabric of cotton-like yarns woven after a draft, at the draft's sett and widths, in its colours if it has some.

    `name` : what it is called; the draft's title by default.
    """
    import numpy as np

    # Drafts state thread and gap carelessly; cloth of which nothing is known is nearly closed.
    widths = [float(np.clip((t / s).mean(), 0.3, 1.1)) for t, s in _widths(draft)]
    colors = "draft" if draft.has_colors else "yarn"
    yarn = {"eta": 1.34, "k_d": 0.35, "gamma_s_deg": 12.0, "gamma_v_deg": 24.0}
    if colors == "yarn":
        yarn["albedo"] = (0.30, 0.27, 0.21)
    weave = Weave.model_validate({"draft": draft, "width": widths, "colors": colors, "twist_deg": 10.0})
    return Fabric.parse({"name": name or draft.title or "draft", "yarn": [yarn, yarn], "weave": weave})


def _widths(draft: Draft) -> tuple:
    return (draft.warp_thickness, draft.warp_spacing), (draft.weft_thickness, draft.weft_spacing)


def builtin_fabrics() -> list[str]:
    """Names of the fabrics that come with glcloth."""
    return sorted(path.stem for path in FABRICS.glob("*.toml"))


def load_fabric(name_or_path: str | Path | Fabric) -> Fabric:
    """Return a built-in fabric by name, or one read from a TOML file or made from a weaver's draft (.wif .dtx .wpo .twa).

    A draft that a fabric file names is looked for beside that file. Raises InputError for an unknown name (with a
    suggestion), a missing or malformed file, an unknown key or a value out of its range.
    """
    if isinstance(name_or_path, Fabric):
        return name_or_path
    text = str(name_or_path)
    path = path_of(text)
    if is_draft(text):
        from ..weave.wif import load_draft

        return draft_fabric(load_draft(path))
    if path.suffix != ".toml" and not path.is_file():
        names = builtin_fabrics()
        if text in names:
            path = FABRICS / f"{text}.toml"
        else:
            hint = meant(text, names, '; did you mean "{}"?')
            raise InputError(
                f'fabric "{text}": not a built-in fabric ({", ".join(names)}) and not a .toml or .wif file{hint}'
            )
    data = read_toml(path, "a fabric file (.toml)")
    weave = data.get("weave")
    if isinstance(weave, dict) and is_draft(str(weave.get("draft", ""))):
        data["weave"] = {**weave, "draft": str(path.parent / weave["draft"])}
    fabric = Fabric.parse(data, str(path))
    if path.parent != FABRICS:
        _warn_of_energy(path, fabric)
    return fabric


_energy_known: set[tuple[Path, int]] = set()  # files and when they changed


def _warn_of_energy(path: Path, fabric: Fabric) -> None:
    """Say once of a file that its fabric gives back more light than it gets."""
    key = path, path.stat().st_mtime_ns
    if key in _energy_known or fabric.energy == "limit" or max(max(yarn.albedo) for yarn in fabric.yarn) < 0.2:
        return
    _energy_known.add(key)
    if fabric.largest_albedo > 1.05:
        warn(
            f"{path}: gives back {fabric.largest_albedo:.2f} times the light that it gets, toward some viewers; lower "
            'the albedos, or set energy = "limit"'
        )


def save_fabric(path: str | Path, fabric: Fabric) -> None:
    """Write a fabric file that `load_fabric` reads back to an equal Fabric. Raises InputError if it cannot be written."""
    import tomli_w

    data = fabric.model_dump(exclude_none=True)
    for yarn in data["yarn"]:
        for name in derived_names(fabric.weave):
            yarn.pop(name, None)
        if yarn.get("samples") == 0:
            yarn["samples"] = "curve"
    with atomic_write(path) as temporary:
        temporary.write_text(tomli_w.dumps(data), encoding="utf-8")
