#version 430
// Light that the probes get back along their rays, summed; and the weights of all their directions.   [own]
// No rays: this runs whenever the lights change.
#include "trace/visibility.glsl"
layout(local_size_x = 64) in;         // and a row of groups for each class
uniform usamplerBuffer hit_data;      // passes/visibility/hits.comp
uniform samplerBuffer radiance_data;  // passes/visibility/bounce_radiance.comp
uniform samplerBuffer vertex_data;    // of what rays meet, three texels a vertex: position, normal, tangent
uniform samplerBuffer probe_data;
uniform samplerBuffer direction_data;
layout(std430) writeonly buffer Sums { vec4 sums[]; };  // of a probe front and back: radiance, weight; luminance x direction, weight of hits
uniform int first_probe[9];           // of each class, and the one after the last
uniform int probe_count;
uniform int class_directions;         // directions of each class in direction_data,
uniform int direction_count;          // and how many of them are traced
uniform float flat_share;             // of the weight of directions, see `response_to`

void main() {
    int i = first_probe[gl_WorkGroupID.y] + int(gl_GlobalInvocationID.x);
    if (i >= first_probe[gl_WorkGroupID.y + 1u]) return;
    vec3 N = texelFetch(probe_data, 2 * i + 1).xyz;
    int base = class_directions * int(gl_WorkGroupID.y);
    vec4 front = vec4(0.0), back = front;
    vec3 from = vec3(0.0), from_back = from;
    vec2 hidden = vec2(0.0);
    for (int d = 0; d < direction_count; ++d) {
        vec3 omega = texelFetch(direction_data, base + d).xyz;
        vec2 w = response_to(dot(omega, N), flat_share);
        uint hit = texelFetch(hit_data, d * probe_count + i).x;
        vec3 L = vec3(0.0);
        if (hit != 0xffffffffu) {
            vec4 sent = texelFetch(radiance_data, int(hit));
            vec3 N_hit = texelFetch(vertex_data, 3 * int(hit >> 1) + 1).xyz;
            L = sent.rgb * max(1.0 + sent.a * (abs(dot(N_hit, omega)) - 2.0 / 3.0), 0.0);
            hidden += w;
        }
        front += w.x * vec4(L, 1.0);
        back += w.y * vec4(L, 1.0);
        w *= dot(L, vec3(0.2126, 0.7152, 0.0722));
        from += w.x * omega;
        from_back += w.y * omega;
    }
    sums[4 * i] = front;
    sums[4 * i + 1] = vec4(from, hidden.x);
    sums[4 * i + 2] = back;
    sums[4 * i + 3] = vec4(from_back, hidden.y);
}
