// A ray and what Woop's triangle test needs of it, once per ray.
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

// (t, v, w, determinant) with the barycentric coordinates of b and c; t = -1 for a miss.
vec4 meet_triangle(Ray ray, vec3 a, vec3 b, vec3 c) {
    return hit_triangle(axis_last(a, ray.axis) - ray.o_last, axis_last(b, ray.axis) - ray.o_last,
                        axis_last(c, ray.axis) - ray.o_last, ray.shear);
}
