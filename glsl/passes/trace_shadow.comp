#version 430
// Adds the lamp's light to the rays that wait for it, attenuated by the cloth on its way.
// With structures that take several dispatches (`resume`), the shadow ray keeps in its radiance what is left so far.
#include "passes/ray.glsl"
#include "passes/visit_attenuate.glsl"
#include "accel.glsl"
layout(local_size_x = 64) in;
layout(binding = 11) uniform samplerBuffer shadows;  // (origin, ray) (direction, t_max) (radiance, -)
layout(std430, binding = 3) buffer Radiances { vec4 radiance[]; };
layout(std430, binding = 6) buffer Shadows { vec4 shadow_out[]; };
uniform int shadow_count;
uniform bool last_chunk;

void main() {
    int i = int(gl_GlobalInvocationID.x);
    if (i >= shadow_count) return;
    vec4 o = texelFetch(shadows, 3 * i);
    vec4 d = texelFetch(shadows, 3 * i + 1);
    vec3 light = texelFetch(shadows, 3 * i + 2).rgb;
    Visit visit = start_visit(d.w);
    Ray ray = make_ray(o.xyz, d.xyz, 0.0, d.w);
    traverse(ray, visit);
    if (visit.t > 0.0) reckon(visit, ray);
    light *= visit.through;
    if (last_chunk) {
        radiance[int(o.w)] += vec4(light, 0.0);
    } else {
        shadow_out[3 * i + 2] = vec4(light, 0.0);
    }
    count_store(i);
}
