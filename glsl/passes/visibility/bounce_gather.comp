#version 430
// Light that the probes get back along their rays, summed; and the weights of all their directions.   [own]
// No rays: this runs whenever the lights change.
layout(local_size_x = 64) in;         // and a row of groups for each class
uniform usamplerBuffer hit_data;      // passes/visibility/hits.comp
uniform samplerBuffer radiance_data;  // passes/visibility/bounce_radiance.comp
uniform samplerBuffer probe_data;
uniform samplerBuffer direction_data;
layout(std430) writeonly buffer Sums { vec4 sums[]; };  // of a probe front and back: radiance, weight; luminance x direction, weight of hits
uniform int first_probe[9];           // of each class, and the one after the last
uniform int probe_count;
uniform int class_directions;         // directions of each class in direction_data,
uniform int direction_count;          // and how many of them are traced
uniform float steepness;              // of the weight of directions

void main() {
    int i = first_probe[gl_WorkGroupID.y] + int(gl_GlobalInvocationID.x);
    if (i >= first_probe[gl_WorkGroupID.y + 1u]) return;
    vec3 N = steepness * texelFetch(probe_data, 2 * i + 1).xyz;
    int base = class_directions * int(gl_WorkGroupID.y);
    vec4 front = vec4(0.0), back = front;
    vec3 from = vec3(0.0), from_back = from;
    vec2 hidden = vec2(0.0);
    for (int d = 0; d < direction_count; ++d) {
        vec3 omega = texelFetch(direction_data, base + d).xyz;
        float cos_theta = dot(omega, N);
        vec2 w = clamp(vec2(cos_theta, -cos_theta), 0.0, 1.0);
        uint hit = texelFetch(hit_data, d * probe_count + i).x;
        vec3 L = vec3(0.0);
        if (hit != 0xffffffffu) {
            L = texelFetch(radiance_data, int(hit)).rgb;
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
