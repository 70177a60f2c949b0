#version 430
// Adds the lamp's light to the rays that wait for it, attenuated by the cloth on its way.
// A shadow ray runs from the lamp to the point: where the lamp is outside, the walls round the window end most of those that
// end at all, long before the folds of the curtain. Far from the scene it begins near it, for the digits of its hits.
// PARTED: also to the kind of light that it is.
// With structures that take several dispatches (`resume`), the shadow ray keeps in its radiance the light left so far.
#include "inputs/accel/ray.glsl"
#include "inputs/tracing/visit_attenuate.glsl"
#include "accel.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
#include "inputs/tracing/counts.glsl"
#ifdef PARTED
#include "inputs/tracing/parts.glsl"
#endif
uniform samplerBuffer shadows;  // (point, ray) (radiance, 1: from behind)
layout(std430) buffer Radiances { vec4 radiance[]; };
layout(std430) buffer Shadows { vec4 shadow_out[]; };
uniform bool last_chunk;
uniform vec3 lamp;         // its position
uniform float beyond;      // further than this from a point of the scene there is nothing
uniform float offset;      // nearer than this to the lamp nothing counts

void main() {
    int i = item();
    if (i >= int(count[SHADOWS])) return;
    vec4 point = texelFetch(shadows, 2 * i);
    vec4 waiting = texelFetch(shadows, 2 * i + 1);
    vec3 light = waiting.rgb;
    vec3 toward = lamp - point.xyz;
    float distance = length(toward);
    vec3 d = toward / max(distance, 1e-12);
    float reach = min(distance - offset, beyond);
    Visit visit = start_visit(reach);
    Ray ray = make_ray(point.xyz + reach * d, -d, 0.0, reach);
    traverse(ray, visit);
    light *= reckon(visit, ray);
    if (last_chunk) {
        radiance[floatBitsToInt(point.w)] += vec4(light, 0.0);
#ifdef PARTED
        kinds[LIGHT_PARTS * floatBitsToInt(point.w) + (waiting.a > 0.0 ? THROUGH : DIRECT)] += vec4(light, 0.0);
#endif
    } else {
        shadow_out[2 * i + 1] = vec4(light, waiting.a);
    }
    count_store(i);
}
