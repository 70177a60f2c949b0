"""Fabrics: what a weave is made of, as frozen values read from TOML."""

from __future__ import annotations

import copy
import difflib
import math
from bisect import bisect_left
from functools import cached_property
from itertools import accumulate
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, Self

from pydantic import BeforeValidator, Field, model_validator

from .errors import InputError, short
from .fields import Value, about
from .files import PACKAGE, atomic_write, path_of, read_toml
from .progress import warn
from .weave.model import Weave
from .weave.others import is_draft

if TYPE_CHECKING:
    import numpy as np  # imported where it is used: the command line starts without it

    from .weave.draft import Draft
    from .weave.tangents import Tangents

FABRICS = PACKAGE / "fabrics"
MAX_TANGENTS = 32  # distinct tangents of a fabric, both yarns together; core/shared.glsl says the same


Albedo = Annotated[float, Field(ge=0.0, le=1.0)]
Tilt = Annotated[float, Field(ge=-90.0, le=90.0)]
Length = Annotated[float, Field(ge=0.0)]
Depth = Annotated[float, Field(ge=0.0, le=20.0)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
# What a weave says of its yarns, so that a file does not say it again.
DERIVED = ("area", "curve_angles_deg", "curve_lengths", "samples", "tangents_deg", "shares")


def _samples(value: Any) -> Any:
    """Files write "curve" for as many samples as the curve needs."""
    return 0 if value == "curve" else value


class Tangent(NamedTuple):
    """One distinct tangent: equal tilts of a yarn are merged, `count` says how many samples it stands for."""

    yarn: int
    tilt: float  # radians
    count: int


class Yarn(Value):
    """One of the two yarns of a weave: the parameters of paper A, equation 5, and its tangent curve."""

    albedo: tuple[Albedo, Albedo, Albedo] = about("linear Rec. 709", "colour of the volume term, A")
    eta: float = about("", "index of refraction", gt=1.0, le=3.0)
    k_d: float = about("", "isotropic share of the volume term", ge=0.0, le=1.0)
    gamma_s_deg: float = about("degrees", "width of the surface lobe", ge=0.5, le=60.0)
    gamma_v_deg: float = about("degrees", "width of the volume lobe", ge=0.5, le=60.0)
    area: float = about("", "share of the weave's area, a_j", ge=0.0, le=1.0)
    curve_angles_deg: tuple[Tilt, ...] | None = about("degrees", "control angles of the tangent curve", default=None)
    curve_lengths: tuple[Length, ...] | None = about("", "segment lengths of the curve (0 = jump)", default=None)
    samples: Annotated[int | None, BeforeValidator(_samples)] = about(
        "",
        'samples equally spaced along the curve, ends included; 0 or "curve": the curve itself',
        default=None,
        ge=0,
        le=32,
    )
    tangents_deg: tuple[Tilt, ...] | None = about(
        "degrees", "the tangents themselves, instead of a curve", default=None
    )

    shares: tuple[Share, ...] | None = about(
        "", "what share of the yarn each of tangents_deg has; equal ones where not given", default=None
    )

    @model_validator(mode="after")
    def _one_description_of_the_tangents(self):
        curve = (self.curve_angles_deg, self.curve_lengths, self.samples)
        if self.tangents_deg is not None:
            if any(part is not None for part in curve):
                raise ValueError("has tangents_deg and a curve, expected one of them; delete the other")
            if not 1 <= len(self.tangents_deg) <= 32:
                raise ValueError(f"tangents_deg has {len(self.tangents_deg)} angles, expected 1 to 32")
            if self.shares is not None:
                if len(self.shares) != len(self.tangents_deg):
                    raise ValueError(
                        f"shares has {len(self.shares)} numbers, expected {len(self.tangents_deg)}, one a tangent"
                    )
                if abs(sum(self.shares) - 1.0) > 1e-6:
                    raise ValueError(f"the shares add up to {sum(self.shares):g}, expected 1; change them")
            return self
        if self.shares is not None:
            raise ValueError("has shares without tangents_deg, expected both; delete shares")
        if any(part is None for part in curve):
            raise ValueError("needs curve_angles_deg, curve_lengths and samples, or tangents_deg instead of the three")
        if len(self.curve_angles_deg) < 2:
            raise ValueError("curve_angles_deg has fewer than 2 angles; give the curve's start and end")
        if len(self.curve_lengths) != len(self.curve_angles_deg) - 1:
            raise ValueError(
                f"curve_lengths has {len(self.curve_lengths)} lengths, expected {len(self.curve_angles_deg) - 1}, "
                f"one between each two of the {len(self.curve_angles_deg)} angles"
            )
        if sum(self.curve_lengths) <= 0:
            raise ValueError("curve_lengths are all 0; give at least one segment a length")
        return self

    @cached_property
    def tilts_deg(self) -> tuple[float, ...]:
        """The sampled tangents C_j in degrees, equal ones repeated."""
        if self.tangents_deg is not None:
            return self.tangents_deg
        if self.samples == 0:
            return tuple(round(math.degrees(tilt), 9) + 0.0 for tilt in self._whole_curve.tilts)
        lengths, angles = self.curve_lengths, self.curve_angles_deg
        ends = [0.0, *accumulate(map(float, lengths))]
        step = ends[-1] / max(self.samples - 1, 1)
        at = [i * step for i in range(self.samples - 1)] + [ends[-1] if self.samples > 1 else ends[-1] / 2]
        tilts = []
        for s in at:
            # A sample that falls on a jump takes the side before it, except at the very start.
            segment = min(max(bisect_left(ends, s) - 1, 0), len(lengths) - 1)
            while lengths[segment] == 0.0:
                segment += 1
            u = (s - ends[segment]) / lengths[segment]
            a, b = angles[segment : segment + 2]
            tilts.append(round(a + (b - a) * min(max(u, 0.0), 1.0), 9))
        return tuple(tilts)

    @cached_property
    def tilt_shares(self) -> tuple[float, ...] | None:
        """What share of the yarn each of `tilts_deg` has; None where all have 1 / N_j."""
        return tuple(self._whole_curve.weights.tolist()) if self.samples == 0 else self.shares

    @cached_property
    def _whole_curve(self) -> Tangents:
        import numpy as np

        from .weave.tangents import curve_tangents

        return curve_tangents(np.radians(self.curve_angles_deg), self.curve_lengths, np.radians(self.gamma_s_deg))


class Transmission(Value):
    """Paper B's terms for the ray tracer: how light passes through the weave.

    The names are those of paper B, equation 1, put right: `rho` is the covered share of the area, so 1 - rho is open
    (`openness`; a file may give that instead of rho), and k_a and k_t weigh the light through the holes and through
    the yarns. No measured parameters have been published; the defaults are plausible for a white sheer.
    """

    rho: float = about("", "yarn density: covered share of the area, 1 - openness", default=0.65, ge=0.0, le=1.0)
    k_a: float = about("", "share of the light in the holes that passes", default=1.0, ge=0.0, le=1.0)
    k_t: float = about("", "share of the light in the yarns that goes on forward", default=0.6, ge=0.0, le=1.0)
    tau: tuple[Depth, Depth, Depth] = about("", "optical depth of the yarns, per channel", default=(0.15, 0.15, 0.15))
    diffuse: float = about("", "Lambertian share of the diffuse transmission", default=0.5, ge=0.0, le=1.0)
    roughness: float = about("", "GGX roughness r of the diffuse transmission", default=0.5, ge=0.02, le=1.0)
    eta_1: float = about("", "refractive index outside", default=1.0, ge=1.0, le=3.0)
    eta_2: float = about("", "refractive index of the yarn", default=1.54, ge=1.0, le=3.0)
    roughness_p: float = about("", "GGX roughness of the directed transmission", default=0.1, ge=0.02, le=1.0)

    @model_validator(mode="before")
    @classmethod
    def _other_spellings(cls, data):
        if isinstance(data, dict):
            data = dict(data)
            if "openness" in data:
                if "rho" in data:
                    raise ValueError("has both openness and rho, expected one of them (rho = 1 - openness); delete one")
                openness = data.pop("openness")
                if not isinstance(openness, int | float) or not 0.0 <= openness <= 1.0:
                    raise ValueError(f"openness = {short(openness)}, expected 0 to 1")
                data["rho"] = 1.0 - openness
            if isinstance(data.get("tau"), int | float):
                data["tau"] = (data["tau"],) * 3
        return data

    @model_validator(mode="after")
    def _two_media(self):
        if abs(self.eta_1 - self.eta_2) < 0.02:
            raise ValueError(
                f"eta_1 = {self.eta_1:g} and eta_2 = {self.eta_2:g} are alike, so nothing refracts; "
                "make them differ by 0.02 or more"
            )
        return self

    @property
    def openness(self) -> float:
        """The share of holes at normal incidence."""
        return 1.0 - self.rho


class Fabric(Value):
    """A fabric: two yarns, the width of shadowing and masking, and which normalisation of W holds.

    `normalization` "sadeghi": W = M P / Q with Q = sum_t w_t P + (1 - a_1 - a_2) max(omega_o . N, 0), w_t = a_j / N_j.
    "paper": equation 6 of paper A as printed, W = M P / sum_t P, without gaps and without 1 / N_j.

    With a `weave` whose `far` is "weave" the yarns' areas and tangents are what the weave makes of them, whatever they said;
    where its threads have colours of their own, so is their albedo.
    """

    name: str = about("", "for people", min_length=1)
    normalization: Literal["sadeghi", "paper"] = about(
        "", "how W is normalised: as Sadeghi et al., or as paper A printed it", default="sadeghi"
    )
    sigma_deg: float = about("degrees", "width of shadowing and masking", default=20.0, ge=1.0, le=90.0)
    energy: Literal["given", "limit"] = about(
        "", "limit: dimmed evenly so that it gives back no more light than it gets", default="given"
    )
    yarn: tuple[Yarn, ...]
    transmission: Transmission | None = None
    weave: Weave | None = None

    @classmethod
    def parse(cls, data: dict, where: str = "") -> Self:
        """As `Value.parse`. Raises InputError also for a yarn that says what follows from the weave."""
        areas, colors = _derives(data.get("weave"))
        derived = (DERIVED if areas else ()) + (("albedo",) if colors else ())
        yarns = data.get("yarn")
        for j, yarn in enumerate(yarns if isinstance(yarns, list) else ()):
            if said := next((name for name in derived if isinstance(yarn, dict) and name in yarn), None):
                other = 'set colors = "yarn"' if said == "albedo" else 'set far = "yarns"'
                raise InputError(f"{where}: yarn {j + 1}: {said}: follows from [weave]; delete it, or {other} there")
        return super().parse(data, where)

    @model_validator(mode="before")
    @classmethod
    def _yarns_that_the_weave_completes(cls, data):
        """Yarns may leave out what is derived."""
        if not isinstance(data, dict) or not isinstance(data.get("yarn"), list | tuple):
            return data
        areas, colors = _derives(data.get("weave"))
        stand_in = ({"area": 0.0, "tangents_deg": (0.0,)} if areas else {}) | ({"albedo": (0.5,) * 3} if colors else {})
        dropped = DERIVED if areas else ()
        yarns = [
            {**{k: v for k, v in yarn.items() if k not in dropped}, **stand_in} if isinstance(yarn, dict) else yarn
            for yarn in data["yarn"]
        ]
        return {**data, "yarn": yarns}

    @model_validator(mode="after")
    def _two_yarns_on_one_area(self):
        if len(self.yarn) != 2:
            raise ValueError(f"has {len(self.yarn)} yarns, expected exactly two [[yarn]] blocks")
        if self.weave is not None:
            self.__dict__["yarn"] = _derived_yarns(self.weave, self.yarn)
        if sum(y.area for y in self.yarn) > 1.0 + 1e-9:
            raise ValueError(f"the areas add up to {sum(y.area for y in self.yarn):g}, expected at most 1")
        if len(self.tangents) > MAX_TANGENTS:
            raise ValueError(f"has {len(self.tangents)} distinct tangents, expected at most {MAX_TANGENTS}")
        return self

    @cached_property
    def tangents(self) -> tuple[Tangent, ...]:
        """The distinct tangents of both yarns with their multiplicities."""
        out = []
        for j, yarn in enumerate(self.yarn):
            counts: dict[float, int] = {}
            for tilt in yarn.tilts_deg:
                counts[tilt] = counts.get(tilt, 0) + 1
            out += [Tangent(j, math.radians(tilt), count) for tilt, count in sorted(counts.items())]
        return tuple(out)

    def sketch(self, side: int = 128) -> Self:
        """An equal fabric whose maps of threads have at most `side` texels a side, for a first answer to an edit."""
        if self.weave is None:
            return self
        out = copy.copy(self)
        out.__dict__["weave"] = self.weave.sketch(side)
        return out

    def dyed(self, color: tuple[float, float, float]) -> Self:
        """The fabric with so much of its yarns' colours [3], linear; what limits its energy is that of the undyed one, and the
        colours of single threads (`weave`) stay."""
        out = copy.copy(self)
        out.__dict__["yarn"] = tuple(
            yarn.changed(albedo=tuple(min(a * c, 1.0) for a, c in zip(yarn.albedo, color, strict=True)))
            for yarn in self.yarn
        )
        out.__dict__["weights"] = self.weights
        return out

    def colored(self, color: tuple[float, float, float]) -> Self:
        """The fabric in another colour [3], linear: as if bleached, then dyed through.

        A yarn reflects so much of what its brightest channel did, and light that goes through it once is coloured alike: its
        optical depth is that of its clearest channel, less ln(color). Slanted ways are longer, and their light is deeper.
        """
        dye = [min(max(float(c), 1e-3), 1.0) for c in color]
        yarns = tuple(y.changed(albedo=tuple(max(y.albedo) * c for c in dye)) for y in self.yarn)
        t = self.transmission
        tau = None if t is None else tuple(min(t.tau) - math.log(c) for c in dye)
        through = {} if t is None else {"transmission": t.changed(tau=tau)}
        return self.changed(yarn=yarns, **through)

    @property
    def sigma(self) -> float:
        """Width of shadowing and masking in radians."""
        return math.radians(self.sigma_deg)

    @property
    def gap(self) -> float:
        """The area that no yarn covers, 1 - a_1 - a_2, as W's normaliser counts it (0 in the paper's printed form)."""
        return max(0.0, 1.0 - self.yarn[0].area - self.yarn[1].area) if self.normalization == "sadeghi" else 0.0

    @cached_property
    def weights(self) -> np.ndarray:
        """[tangents, 2]: the factor of each distinct tangent in the sum over tangents, and its factor in W's normaliser.

        sadeghi: both are a_j count / N_j. paper (equation 6 as printed): a_j count, and count. Where tangents have shares
        of their own, N_j times the share stands for count. With `energy` "limit" the first is divided by the largest
        share of the light that the fabric would give back, if that is above 1.
        """
        if self.energy == "given":
            return self._weights
        return self._weights * (1.0 / max(self.largest_albedo, 1.0), 1.0)

    @cached_property
    def largest_albedo(self) -> float:
        """The share of even light from the hemisphere that the fabric, its energy not limited, gives back toward the
        brightest of 24 directions, in the brightest channel."""
        if self.energy == "limit":
            return self.changed(energy="given").largest_albedo
        import numpy as np

        from .twins.cloth import f_cloth
        from .twins.directions import even_directions

        cos, azimuth = (a.ravel() for a in np.meshgrid([0.1, 0.25, 0.4, 0.6, 0.8, 1.0], np.radians([1, 45, 91, 135])))
        sin = np.sqrt(1.0 - cos**2)
        views = np.stack([sin * np.cos(azimuth), sin * np.sin(azimuth), cos], -1)
        f = f_cloth(even_directions(512), views[:, None], *self.arrays())
        return float(2.0 * np.pi * f.mean(1).max())

    @cached_property
    def _weights(self) -> np.ndarray:
        import numpy as np

        rows = []
        for yarn, tilt, count in self.tangents:
            factor: float = count
            if (shares := self.yarn[yarn].tilt_shares) is not None:
                tilts = self.yarn[yarn].tilts_deg
                factor = sum(s for s, t in zip(shares, tilts, strict=True) if math.radians(t) == tilt) * len(shares)
            if self.normalization == "sadeghi":
                w = self.yarn[yarn].area * factor / len(self.yarn[yarn].tilts_deg)
                rows.append((w, w))
            else:
                rows.append((self.yarn[yarn].area * factor, float(factor)))
        return np.array(rows)

    def numerators(self, part: int | None = None) -> np.ndarray:
        """The factors [tangents] in the sum over tangents; `part`: that of one tangent, the others are 0.

        W's normaliser keeps all tangents, so the radiances of all parts add up to that of the fabric.
        """
        import numpy as np

        numerators = self.weights[:, 0]
        return numerators if part is None else np.where(np.arange(len(numerators)) == part, numerators, 0.0)

    def arrays(self, part: int | None = None) -> tuple:
        """(yarns, tangents, weights, gap, sigma) as the functions of glcloth.twins take them; `part` as in `numerators`."""
        import numpy as np

        yarns = [
            {
                "A": np.array(y.albedo),
                "eta": y.eta,
                "k_d": y.k_d,
                "gamma_s": np.radians(y.gamma_s_deg),
                "gamma_v": np.radians(y.gamma_v_deg),
            }
            for y in self.yarn
        ]
        weights = np.column_stack([self.numerators(part), self.weights[:, 1]])
        return yarns, [tuple(t) for t in self.tangents], weights, self.gap, self.sigma


def _derives(weave: Any) -> tuple[bool, bool]:
    """Whether a weave, be it a Weave or a table of a file, says areas and tangents of the yarns, and their colours."""
    if isinstance(weave, Weave):
        return weave.far == "weave", weave.colors != "yarn"
    if isinstance(weave, dict):
        return weave.get("far", "weave") == "weave", weave.get("colors", "yarn") != "yarn"
    return False, False


def _derived_yarns(weave: Weave, yarns: tuple[Yarn, ...]) -> tuple[Yarn, ...]:
    """The yarns with what the weave makes of them."""
    areas, colors = _derives(weave)
    if not areas and not colors:
        return yarns
    found = weave.derived(tuple(yarn.gamma_s_deg for yarn in yarns))
    out = []
    for j, yarn in enumerate(yarns):
        data = {name: getattr(yarn, name) for name in Yarn.model_fields}
        if areas:
            data = {k: v for k, v in data.items() if k not in DERIVED}
            data |= {"area": found.areas[j], "tangents_deg": found.tilts_deg[j], "shares": found.shares[j]}
        if colors:
            data["albedo"] = found.albedos[j]
        out.append(Yarn.model_validate(data))
    return tuple(out)


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
        from .weave.wif import load_draft

        return draft_fabric(load_draft(path))
    if path.suffix != ".toml" and not path.is_file():
        names = builtin_fabrics()
        if text in names:
            path = FABRICS / f"{text}.toml"
        else:
            close = difflib.get_close_matches(text.lower(), names, 1, 0.4)
            hint = f'; did you mean "{close[0]}"?' if close else ""
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
    areas, colors = _derives(fabric.weave)
    derived = (DERIVED if areas else ()) + (("albedo",) if colors else ())
    for yarn in data["yarn"]:
        for name in derived:
            yarn.pop(name, None)
        if yarn.get("samples") == 0:
            yarn["samples"] = "curve"
    with atomic_write(path) as temporary:
        temporary.write_text(tomli_w.dumps(data), encoding="utf-8")
