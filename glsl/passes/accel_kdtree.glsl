// Traversal of the kd-tree with a stack, near child first.   [Zhou 2008, section 4; Havran 2000]
// Needs struct Ray, struct Visit, reach() and meet() from the pass that includes it. meet() is told the part of the ray
// that lies in the leaf.
#include "trace/shared.glsl"
#include "count.glsl"

layout(binding = 8) uniform usamplerBuffer tree_nodes;    // passes/kdtree_emit.comp says how they are packed
layout(binding = 9) uniform usamplerBuffer leaf_corners;  // passes/kdtree_leaves.comp
uniform vec3 scene_low;
uniform vec3 scene_high;

void traverse(Ray ray, inout Visit visit) {
    vec3 inv_d = safe_inverse(ray.d);
    vec2 range = slab(ray.o, inv_d, scene_low, scene_high);
    float t_0 = max(range.x, 0.0);
    float t_1 = min(range.y, ray.t_max);
    if (!(t_0 <= t_1)) return;
    uint far_node[STACK];
    float far_end[STACK];
    int top = 0;
    uint at = 0u;
    while (true) {
        uvec2 node = texelFetch(tree_nodes, int(at)).xy;
        while ((node.y & 3u) != 3u) {
            count_step();
            uint axis = node.y & 3u;
            float plane = uintBitsToFloat(node.x);
            // Selections instead of indexing with `axis`: an indexed vector goes through memory.
            float o = axis == 0u ? ray.o.x : axis == 1u ? ray.o.y : ray.o.z;
            float d = axis == 0u ? ray.d.x : axis == 1u ? ray.d.y : ray.d.z;
            float inverse = axis == 0u ? inv_d.x : axis == 1u ? inv_d.y : inv_d.z;
            float t = (plane - o) * inverse;
            // A ray that starts on the plane begins on the side it goes to.
            bool below = o < plane || o == plane && d <= 0.0;
            uint left = at + 1u;
            uint right = node.y >> 2;
            uint near = below ? left : right;
            uint far = below ? right : left;
            bool only_near = t > t_1 || t <= 0.0;
            bool only_far = !only_near && t < t_0;
            at = only_far ? far : near;
            if (!only_near && !only_far) {
                far_node[top] = far;
                far_end[top] = t_1;
                ++top;
                t_1 = t;
            }
            node = texelFetch(tree_nodes, int(at)).xy;
        }
        int last = int(node.x + (node.y >> 2));
        for (int i = int(node.x); i < last; ++i) {
            count_test();
            uvec4 a = texelFetch(leaf_corners, 3 * i);
            vec3 b = uintBitsToFloat(texelFetch(leaf_corners, 3 * i + 1).xyz);
            vec3 c = uintBitsToFloat(texelFetch(leaf_corners, 3 * i + 2).xyz);
            meet(visit, ray, a.w, meet_triangle(ray, uintBitsToFloat(a.xyz), b, c), vec2(t_0, t_1));
        }
        // A triangle that reaches out of its leaf may be hit beyond it: only a hit within ends the search.
        if (top == 0 || reach(visit) <= t_1) return;
        --top;
        t_0 = t_1;
        at = far_node[top];
        t_1 = far_end[top];
    }
}
