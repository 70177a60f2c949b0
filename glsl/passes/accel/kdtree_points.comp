#version 430
// One reference for each point, as passes/accel/kdtree_init.comp makes them of triangles: its box is the point itself.
#include "trace/shared.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform usamplerBuffer points;  // two texels each: (x, y, z, -) and what it carries
layout(std430) writeonly buffer Refs { uvec4 ref_out[]; };
layout(std430) writeonly buffer Nodes { uvec4 node[]; };
layout(std430) writeonly buffer Active { uint next_active[]; };
uniform int pair_count;
uniform float padding;

void main() {
    int i = item();
    if (i >= pair_count) return;
    vec3 p = uintBitsToFloat(texelFetch(points, 2 * i).xyz);
    ref_out[2 * i] = uvec4(floatBitsToUint(p - padding), 2u * uint(i));
    ref_out[2 * i + 1] = uvec4(floatBitsToUint(p + padding), 0u);
    if (i == 0) {
        node[0] = uvec4(0u);
        node[1] = uvec4(0u);
        node[2] = uvec4(0u, PENDING, 0u, 0u);
        node[3] = uvec4(0u, uint(pair_count), 0u, 0u);
        next_active[0] = 0u;
    }
}
