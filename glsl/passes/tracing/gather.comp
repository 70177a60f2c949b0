#version 430
// Adds to each ray of a generation its children's light; PARTED: also to its kinds.   [Mat section 4.2, step 6]
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
#ifdef PARTED
#include "inputs/tracing/parts.glsl"
#endif
uniform samplerBuffer next_radiance;
uniform usamplerBuffer children;
layout(std430) buffer Radiances { vec4 radiance[]; };
uniform int ray_count;
uniform int front_count;
uniform int back_first;

void main() {
    int i = item();
    if (i >= ray_count) return;
    if (i >= front_count) i += back_first - front_count;
    uvec2 next = texelFetch(children, i).xy;
    vec4 sum = vec4(0.0);
    if (next.x != 0xffffffffu) sum += texelFetch(next_radiance, int(next.x));
    if (next.y != 0xffffffffu) sum += texelFetch(next_radiance, int(next.y));
    if (next != uvec2(0xffffffffu)) radiance[i] += sum;
#ifdef PARTED
    if (next.x != 0xffffffffu) kinds[LIGHT_PARTS * i + THROUGH] += texelFetch(next_radiance, int(next.x));
    if (next.y != 0xffffffffu) kinds[LIGHT_PARTS * i + BOUNCE] += texelFetch(next_radiance, int(next.y));
#endif
}
