// Traversal of the bounding volume hierarchy with a stack, the nearer child first.   [Aila and Laine 2009]
// Needs struct Ray, struct Visit, t_limit() and accept() from the pass that includes it.
#include "trace/shared.glsl"
#include "count.glsl"

uniform usamplerBuffer bvh_nodes;     // passes/accel/lbvh_emit.comp
uniform usamplerBuffer leaf_corners;  // passes/accel/lbvh_leaves.comp

void traverse(Ray ray, inout Visit visit) {
    vec3 inv_d = safe_inverse(ray.d);
    uint waiting[BVH_STACK];
    float waiting_from[BVH_STACK];
    int top = 0;
    uint at = 0u;
    while (true) {
        bool inner = (at & 0x80000000u) == 0u;
        // Tests stand at the end, as in inputs/accel/kdtree.glsl.
        do {
            if (inner) {
                count_step();
                int n = int(4u * at);
                uvec4 left = texelFetch(bvh_nodes, n);
                uvec4 right = texelFetch(bvh_nodes, n + 2);
                vec2 l = slab(ray.o, inv_d, uintBitsToFloat(left.xyz), uintBitsToFloat(texelFetch(bvh_nodes, n + 1).xyz));
                vec2 r = slab(ray.o, inv_d, uintBitsToFloat(right.xyz), uintBitsToFloat(texelFetch(bvh_nodes, n + 3).xyz));
                float limit = min(t_limit(visit), ray.t_max);
                bool in_left = max(l.x, 0.0) <= min(l.y, limit);
                bool in_right = max(r.x, 0.0) <= min(r.y, limit);
                bool left_first = in_left && (!in_right || l.x <= r.x);
                if (in_left && in_right) {
                    waiting[top] = left_first ? right.w : left.w;
                    waiting_from[top] = left_first ? r.x : l.x;
                    ++top;
                }
                at = left_first ? left.w : right.w;
                // Neither: a leaf without triangles.
                if (!in_left && !in_right) at = 0x80000000u;
                inner = (at & 0x80000000u) == 0u;
            }
        } while (inner);
        int first = int((at & 0x7fffffffu) >> 3);
        int last = first + int(at & 7u);
        int i = first;
        do {
            if (i < last) {
                count_test();
                uvec4 a = texelFetch(leaf_corners, 3 * i);
                vec3 b = uintBitsToFloat(texelFetch(leaf_corners, 3 * i + 1).xyz);
                vec3 c = uintBitsToFloat(texelFetch(leaf_corners, 3 * i + 2).xyz);
                accept(visit, ray, a.w, meet_triangle(ray, uintBitsToFloat(a.xyz), b, c), vec2(-3e38, 3e38));
            }
            ++i;
        } while (i < last);
        // A node that begins beyond the nearest hit is not worth a visit.
        at = 0xffffffffu;
        bool search = top > 0;
        do {
            top -= search ? 1 : 0;
            bool found = search && waiting_from[top] <= t_limit(visit);
            at = found ? waiting[top] : at;
            search = search && !found && top > 0;
        } while (search);
        if (at == 0xffffffffu) return;
    }
}
