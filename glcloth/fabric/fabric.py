"""A fabric: two yarns and how they are woven, as one frozen value."""

from __future__ import annotations

import copy
import math
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Self

from pydantic import model_validator

from ..errors import InputError
from ..fields import Value, about
from ..weave.model import Weave
from .transmission import Transmission
from .yarn import Yarn

if TYPE_CHECKING:
    import numpy as np  # imported where it is used: the command line starts without it

MAX_TANGENTS = 32  # distinct tangents of a fabric, both yarns together; core/shared.glsl says the same
# What a weave says of its yarns, so that a file does not say it again.
DERIVED = ("area", "curve_angles_deg", "curve_lengths", "samples", "tangents_deg", "shares")


class Tangent(NamedTuple):
    """One distinct tangent: equal tilts of a yarn are merged, `count` says how many samples it stands for."""

    yarn: int
    tilt: float  # radians
    count: int


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
        derived = derived_names(data.get("weave"))
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

        from ..twins.cloth import f_cloth
        from ..twins.directions import even_directions

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


def derived_names(weave: Any) -> tuple[str, ...]:
    """What a yarn must not say beside a weave, be it a Weave or a table of a file: it follows from that."""
    areas, colors = _derives(weave)
    return (DERIVED if areas else ()) + (("albedo",) if colors else ())


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
