// Traversal of the kd-tree with a stack, near child first.   [Zhou 2008, section 4; Havran 2000]
// Needs struct Ray, struct Visit, t_limit() and accept() from the pass that includes it. accept() gets the ray's part
// in the leaf. A visitor that defines SETTLES also has settle(), called after each leaf: true to go through the leaf
// again, for hits behind the last one.
// A software rasteriser executes the body of a loop whose test stands at the top once more than it is wanted, for no lane;
// so tests stand at the end.
#include "trace/shared.glsl"
#include "count.glsl"

uniform usamplerBuffer tree_nodes;    // passes/accel/kdtree_emit.comp says how they are packed
uniform usamplerBuffer leaf_corners;  // passes/accel/kdtree_leaves.comp
uniform usamplerBuffer tree_box;      // the root's: low, high

void traverse(Ray ray, inout Visit visit) {
    vec3 inv_d = safe_inverse(ray.d);
    vec2 range = slab(ray.o, inv_d, uintBitsToFloat(texelFetch(tree_box, 0).xyz), uintBitsToFloat(texelFetch(tree_box, 1).xyz));
    float t_0 = max(range.x, 0.0);
    float t_1 = min(range.y, ray.t_max);
    if (!(t_0 <= t_1)) return;
    uint far_node[STACK];
    float far_end[STACK];
    int top = 0;
    uint at = 0u;
    bool more;
    do {
        uvec2 node = texelFetch(tree_nodes, int(at)).xy;
        bool inner = (node.y & 3u) != 3u;
        do {
            if (inner) {
                count_step();
                uint axis = node.y & 3u;
                // Selections instead of indexing with `axis`: an indexed vector goes through memory.
                float o = axis == 0u ? ray.o.x : axis == 1u ? ray.o.y : ray.o.z;
                float inverse = axis == 0u ? inv_d.x : axis == 1u ? inv_d.y : inv_d.z;
                float t = (uintBitsToFloat(node.x) - o) * inverse;
                // The ray meets the left child first when it goes up the axis; which of the two it meets, t tells.
                bool up = inverse > 0.0;
                bool meets_first = t >= t_0;
                bool meets_both = meets_first && t <= t_1;
                uint right = node.y >> 2;
                // Written in any case, and kept only if `top` moves on.
                far_node[top] = up ? right : at + 1u;
                far_end[top] = t_1;
                top += meets_both ? 1 : 0;
                t_1 = meets_both ? t : t_1;
                at = meets_first == up ? at + 1u : right;
                node = texelFetch(tree_nodes, int(at)).xy;
                inner = (node.y & 3u) != 3u;
            }
        } while (inner);
        int i = int(node.x);
        int last = int(node.x + (node.y >> 2));
        do {
            if (i < last) {
                count_test();
                uvec4 a = texelFetch(leaf_corners, 4 * i);
                uvec4 b = texelFetch(leaf_corners, 4 * i + 1);
                vec3 c = uintBitsToFloat(texelFetch(leaf_corners, 4 * i + 2).xyz);
                vec3 d = uintBitsToFloat(texelFetch(leaf_corners, 4 * i + 3).xyz);
                if (b.w != NO_TRIANGLE) count_test();
                vec4 hit_1;
                vec4 hit_2;
                meet_pair(ray, uintBitsToFloat(a.xyz), uintBitsToFloat(b.xyz), c, d, hit_1, hit_2);
                accept(visit, ray, a.w, hit_1, vec2(t_0, t_1));
                accept(visit, ray, b.w, hit_2, vec2(t_0, t_1));
            }
            ++i;
        } while (i < last);
        bool again = false;
#ifdef SETTLES
        again = settle(visit, t_1);
#endif
        // A triangle that reaches out of its leaf may be hit beyond it: only a hit within ends the search.
        bool onward = !again && top > 0 && t_limit(visit) > t_1;
        more = again || onward;
        top -= onward ? 1 : 0;
        t_0 = onward ? t_1 : t_0;
        at = onward ? far_node[top] : at;
        t_1 = onward ? far_end[top] : t_1;
    } while (more);
}
