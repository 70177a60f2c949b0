// The light of a direction, or of the surface that hides it: "along.glsl" with shadows.
#include "inputs/accel/ray.glsl"
#include "visit.glsl"
#include "accel.glsl"
#include "inputs/visibility/bounced.glsl"

// `direction.w` is 1 where a ray decides; `light` is flux and solid angle.
vec3 flux_along(vec3 origin, vec4 direction, vec4 light) {
#if defined(PARTS) || defined(CATCHER)
    came_back = false;
#endif
    if (direction.w == 0.0) return light.rgb;
    Visit visit = Visit(3e38, NO_TRIANGLE, vec2(0.0));
    traverse(make_ray(origin, direction.xyz, 0.0, 3e38), visit);
#if defined(PARTS) || defined(CATCHER)
    came_back = visit.triangle != NO_TRIANGLE;
#endif
    return visit.triangle == NO_TRIANGLE ? light.rgb : light.a * bounced(visit, origin, direction.xyz);
}
