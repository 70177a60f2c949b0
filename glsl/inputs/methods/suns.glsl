// What the suns add to a method's sum: one evaluation of the fabric for what the horizon leaves of each disc.   [own]
#include "inputs/picture/fabric.glsl"
#include "inputs/picture/lights.glsl"
#include "trace/sun_disc.glsl"
#include "seen.glsl"

vec3 L_suns(vec3 omega_o, mat3 surface_from_world) {
    vec3 sum = vec3(0.0);
    for (int s = 0; s < sun_count; ++s) {
        Sun sun = fetch_sun(s);
        vec4 part = disc_above(surface_from_world * sun.omega, sun.sin_radius);
        sum += V_sun(s) * part.w * sun.E * f_cloth(part.xyz, omega_o);
    }
    return sum;
}
