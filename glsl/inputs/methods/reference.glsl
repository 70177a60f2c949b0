// Method `reference`: the sum over every direction of a cube map, as paper A's reference pictures.   [Miz section 4]
// Each pass adds `direction_count` directions from `first_direction` on; so no invocation nears a loop limit.
#include "inputs/picture/fabric.glsl"

uniform samplerBuffer direction_data;  // pairs: (omega, -), (radiance x solid angle, -)
uniform int first_direction;
uniform int direction_count;

vec3 L_o(vec3 omega_o, mat3 surface_from_world) {
    vec3 sum = vec3(0.0);
    for (int d = first_direction; d < first_direction + direction_count; ++d) {
        vec3 omega_i = surface_from_world * texelFetch(direction_data, 2 * d).xyz;
        sum += texelFetch(direction_data, 2 * d + 1).rgb * f_cloth(omega_i, omega_o);
    }
    return sum;
}
