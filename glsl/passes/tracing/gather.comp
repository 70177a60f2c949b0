#version 430
// Adds to each ray of a generation its children's light; PARTED: also to its kinds.   [Mat section 4.2, step 6]
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
#include "inputs/tracing/counts.glsl"
#ifdef PARTED
#include "inputs/tracing/parts.glsl"
#endif
uniform samplerBuffer next_radiance;
uniform usamplerBuffer children;
layout(std430) buffer Radiances { vec4 radiance[]; };
uniform int level;      // of the generation
uniform int capacity;   // rays that it has room for

void main() {
    int i = item(), ray_count = int(count[LOG + LOG_COUNTS * level]), front_count = int(count[LOG + LOG_COUNTS * level + 1]);
    // Where there was no room, children may lie behind the end; the tile is traced anew.
    if (i >= ray_count || count[NEED_RAYS] + count[NEED_HEADS] > 0u) return;
    // The others lie at the very end of the queue.
    if (i >= front_count) i += capacity - ray_count;
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
