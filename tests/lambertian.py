"""Method `reference` with a Lambertian in place of the fabric: what other renderers can check."""

import numpy as np

from glcloth.cloth.brute import Reference
from glcloth.files import GLSL

BRDF = """
uniform vec3 albedo;

vec3 f_cloth(vec3 omega_i, vec3 omega_o) {
    return min(omega_i.z, omega_o.z) <= 0.0 ? vec3(0.0) : albedo * omega_i.z / 3.14159265358979;
}
"""
FABRIC = '#include "passes/fabric.glsl"\n'


class LambertianReference(Reference):
    """The reference as it is, but for `f_cloth`, which is albedo / pi times the cosine."""

    def __init__(self, ctx, albedo):
        super().__init__(ctx)
        self.albedo = np.asarray(albedo, float)

    @property
    def source(self):
        text = (GLSL / super().source).read_text(encoding="utf-8")
        assert text.count(FABRIC) == 1
        return text.replace(FABRIC, BRDF)

    def diffuse_albedo(self, fabric):
        return self.albedo

    def bind(self, program):
        super().bind(program)
        program["albedo"].value = tuple(self.albedo)
