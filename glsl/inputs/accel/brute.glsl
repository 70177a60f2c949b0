// Every triangle, one after the other: the judge of the other structures. A dispatch does `test_count` triangles from
// `first_test` on, because loops may end silently after 65,535 iterations.
#include "trace/shared.glsl"
#include "count.glsl"

uniform usamplerBuffer corners;
uniform usamplerBuffer attributes;
uniform int first_test;
uniform int test_count;

void traverse(Ray ray, inout Visit visit) {
    for (int i = first_test; i < first_test + test_count; ++i) {
        count_test();
        vec3 a = uintBitsToFloat(texelFetch(corners, 3 * i).xyz);
        vec3 b = uintBitsToFloat(texelFetch(corners, 3 * i + 1).xyz);
        vec3 c = uintBitsToFloat(texelFetch(corners, 3 * i + 2).xyz);
        uint tag = uint(i) | (texelFetch(attributes, i).x != 0u ? SOLID : 0u);
        accept(visit, ray, tag, meet_triangle(ray, a, b, c), vec2(-3e38, 3e38));
    }
}
