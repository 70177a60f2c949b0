// Cloth that lets light through, where rays meet it: how much of their light goes straight on.   [own]
#include "inputs/accel/ray.glsl"
#include "inputs/accel/visit_closest.glsl"
#include "accel.glsl"
#include "inputs/visibility/sheet_at.glsl"

// The light that is left along a ray of all that comes from far away, and what it meets first.
vec3 left_along(vec3 origin, vec3 d, out Visit first) {
    vec3 T = vec3(1.0);
    float from = 0.0;
    int n = 0;
    do {
        Visit visit = Visit(3e38, NO_TRIANGLE, vec2(0.0));
        traverse(make_ray(origin, d, from, 3e38), visit);
        if (n == 0) first = visit;
        if (visit.triangle == NO_TRIANGLE) return T;
        T *= T_s_of(sheet_at(visit, d));
        from = behind_layer(visit.t);
    } while (worth(T) && ++n < MOST_LAYERS);
    return vec3(0.0);
}

// As one number.
float seen_along(vec3 origin, vec3 d, out Visit first) {
    return dot(left_along(origin, d, first), vec3(0.2126, 0.7152, 0.0722));
}
