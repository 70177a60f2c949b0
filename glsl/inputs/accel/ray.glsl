// A ray, and the values for Woop's triangle test, once per ray.
#include "trace/intersect.glsl"

struct Ray {
    vec3 o;
    vec3 d;
    float t_min;
    float t_max;
    int axis;     // the longest of d
    vec3 shear;
    vec3 o_last;  // o with that axis last
};

Ray make_ray(vec3 o, vec3 d, float t_min, float t_max) {
    int axis = longest_axis(d);
    return Ray(o, d, t_min, t_max, axis, shear_of(axis_last(d, axis)), axis_last(o, axis));
}

// Two triangles (a, c, b) and (b, c, d) that share an edge, each as meet_triangle would find it to the last bit.
void meet_pair(Ray ray, vec3 a, vec3 b, vec3 c, vec3 d, out vec4 hit_1, out vec4 hit_2) {
    a = axis_last(a, ray.axis) - ray.o_last;
    b = axis_last(b, ray.axis) - ray.o_last;
    c = axis_last(c, ray.axis) - ray.o_last;
    d = axis_last(d, ray.axis) - ray.o_last;
    vec2 A = sheared(a, ray.shear);
    vec2 B = sheared(b, ray.shear);
    vec2 C = sheared(c, ray.shear);
    vec2 D = sheared(d, ray.shear);
    float shared_edge = edge_function(B, C);
    hit_1 = hit_edges(vec3(shared_edge, edge_function(A, B), edge_function(C, A)), vec3(a.z, c.z, b.z), ray.shear);
    hit_2 = hit_edges(vec3(edge_function(D, C), edge_function(B, D), -shared_edge), vec3(b.z, c.z, d.z), ray.shear);
}

// (t, v, w, determinant) with the barycentric coordinates of b and c; t = -1 for a miss.
vec4 meet_triangle(Ray ray, vec3 a, vec3 b, vec3 c) {
    return hit_triangle(axis_last(a, ray.axis) - ray.o_last, axis_last(b, ray.axis) - ray.o_last,
                        axis_last(c, ray.axis) - ray.o_last, ray.shear);
}
