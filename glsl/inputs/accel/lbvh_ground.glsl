// The bounding volume hierarchy, and under it a horizontal plane without end.
#define traverse traverse_triangles
#include "inputs/accel/lbvh.glsl"
#undef traverse
#include "trace/ground.glsl"
uniform float ground_height;

void traverse(Ray ray, inout Visit visit) {
    // A ray along the plane never meets it.
    float t = ray.d.y != 0.0 ? (ground_height - ray.o.y) / ray.d.y : -1.0;
    accept(visit, ray, GROUND, vec4(t, 0.0, 0.0, 1.0), vec2(-3e38, 3e38));
    // Who asks whether anything is hit at all knows it now.
    if (t_limit(visit) > ray.t_min) traverse_triangles(ray, visit);
}
