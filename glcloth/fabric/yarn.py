"""A yarn: its scattering, its share of the weave, and the tangents it shows."""

from __future__ import annotations

import math
from bisect import bisect_left
from functools import cached_property
from itertools import accumulate
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BeforeValidator, Field, model_validator

from ..fields import Value, about

if TYPE_CHECKING:
    from ..weave.tangents import Tangents

Albedo = Annotated[float, Field(ge=0.0, le=1.0)]
Tilt = Annotated[float, Field(ge=-90.0, le=90.0)]
Length = Annotated[float, Field(ge=0.0)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]


def _samples(value: Any) -> Any:
    """Files write "curve" for as many samples as the curve needs."""
    return 0 if value == "curve" else value


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

        from ..weave.tangents import curve_tangents

        return curve_tangents(np.radians(self.curve_angles_deg), self.curve_lengths, np.radians(self.gamma_s_deg))
