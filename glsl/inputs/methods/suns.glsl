// What the suns add, the same for every method: one exact evaluation of the fabric per sun.   [own]
#include "inputs/picture/fabric.glsl"
#include "inputs/picture/lights.glsl"
#include "seen.glsl"

vec3 L_suns(vec3 omega_o, mat3 surface_from_world) {
    vec3 sum = vec3(0.0);
    for (int s = 0; s < sun_count; ++s) {
        Sun sun = fetch_sun(s);
        sum += V_sun(s) * sun.E * f_cloth(surface_from_world * sun.omega, omega_o);
    }
    return sum;
}
