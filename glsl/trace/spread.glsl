// Directions through a sheet of cloth, drawn from its lobes.   Twin: glcloth/twins/spread.py
// omega_o points toward the viewer in the frame with z = N; drawn directions point away on the other side (z < 0).
#include "core/math.glsl"
#include "trace/random.glsl"
#include "woven/sheet.glsl"

// [own]  Light that passes straight on: (through the yarns, through the holes); their sum is T_sheet.
vec4 straight_parts(vec3 omega_o, float k_a, float k_t, vec3 tau, float rho) {
    float open = T_open(omega_o, rho);
    return vec4((1.0 - open) * k_t * absorption(omega_o, omega_o, tau), k_a * open);
}

// [own]  The chance with which a hole is drawn instead of a yarn, of such parts.
float hole_chance(vec4 parts) { return parts.a / max(parts.a + largest(parts.rgb), 1e-12); }

// [own]  The weight of a ray drawn through a hole (`hole` = 1) or through the yarns (0).
vec3 drawn_weight(vec4 parts, int hole) {
    float chance = hole_chance(parts);
    return hole == 1 ? vec3(parts.a / max(chance, 1e-12)) : parts.rgb / max(1.0 - chance, 1e-12);
}

// [own]  A direction through the yarns by three numbers from 0 to 1: `part` chooses between the lobes of f_yarn, u is drawn
// in the lobe. Where a facet sends no light through, it goes on straight.
vec3 yarn_direction(vec3 omega_o, vec2 u, float part, float roughness, float eta_1, float eta_2, float diffuse,
                    float roughness_p) {
    vec3 d;
    if (part < 0.5) {
        vec3 r = reflect(-omega_o, facet_direction(u, roughness_p));
        d = vec3(r.xy, -r.z);
    } else if (part < 0.5 + 0.5 * diffuse) {
        d = -cosine_direction(u);
    } else {
        d = refract(-omega_o, facet_direction(u, roughness), eta_1 / eta_2);
    }
    return d.z < 0.0 ? d : -omega_o;
}
