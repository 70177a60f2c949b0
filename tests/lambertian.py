"""Method `reference` with a Lambertian in place of the fabric: what other renderers can check."""

import numpy as np

from glcloth.files import GLSL
from glcloth.methods.reference import Reference

BRDF = """
uniform vec3 albedo;

vec3 f_cloth(vec3 omega_i, vec3 omega_o) {
    return min(omega_i.z, omega_o.z) <= 0.0 ? vec3(0.0) : albedo * omega_i.z / 3.14159265358979;
}
"""
FABRIC = '#include "inputs/picture/fabric.glsl"\n'
ORIGIN = "vec3 origin = origin_at(ivec2(gl_FragCoord.xy));"
# On the flat triangle, as other renderers start their rays, and off it by 1e-3 of its size.
FLAT_ORIGIN = """
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    int t = 3 * triangle_at(pixel);
    vec3 a = texelFetch(vertex_data, 3 * texelFetch(corner_index, t).x).xyz;
    vec3 b = texelFetch(vertex_data, 3 * texelFetch(corner_index, t + 1).x).xyz;
    vec3 c = texelFetch(vertex_data, 3 * texelFetch(corner_index, t + 2).x).xyz;
    vec3 across = cross(b - a, c - a);
    across *= dot(across, origin_at(pixel) - a) < 0.0 ? -1.0 : 1.0;
    vec3 origin = mat3(a, b, c) * weights_at(pixel) + 1e-3 * inversesqrt(length(across)) * across;
"""


class LambertianReference(Reference):
    """The reference as it is, but for `f_cloth`, which is albedo / pi times the cosine; `flat`: rays start on the flat
    triangles instead of the curved surface."""

    def __init__(self, ctx, albedo, flat=False):
        super().__init__(ctx)
        self.flat = flat
        self.lambertian = np.asarray(albedo, float)

    @property
    def source(self):
        text = (GLSL / super().source).read_text(encoding="utf-8")
        assert text.count(FABRIC) == 1
        if self.flat and self.traced:
            assert text.count(ORIGIN) == 1
            text = text.replace(ORIGIN, FLAT_ORIGIN)
        return text.replace(FABRIC, BRDF)

    def prepare(self, *what, **part):
        super().prepare(*what, **part)
        self.albedo = self.lambertian if self.bounces else self.albedo

    def inputs(self):
        return {**super().inputs(), "albedo": tuple(self.lambertian)}
