"""How light passes through a fabric."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from ..errors import short
from ..fields import Value, about

Depth = Annotated[float, Field(ge=0.0, le=20.0)]


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
