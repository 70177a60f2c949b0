// Every triangle, one after the other: the judge of the other structures. A dispatch does `test_count` triangles from
// `first_test` on, because loops may end silently after 65,535 iterations.
#include "count.glsl"

layout(binding = 8) uniform usamplerBuffer corners;
uniform int first_test;
uniform int test_count;

void traverse(Ray ray, inout Visit visit) {
    for (int i = first_test; i < first_test + test_count; ++i) {
        count_test();
        vec3 a = uintBitsToFloat(texelFetch(corners, 3 * i).xyz);
        vec3 b = uintBitsToFloat(texelFetch(corners, 3 * i + 1).xyz);
        vec3 c = uintBitsToFloat(texelFetch(corners, 3 * i + 2).xyz);
        meet(visit, ray, uint(i), meet_triangle(ray, a, b, c), vec2(-3e38, 3e38));
    }
}
