// What is seen along a ray, where no cloth lets light through: the nearest hit, or whether there is any.
#include "inputs/accel/ray.glsl"
#include "inputs/tracing/visit_either.glsl"
#include "accel.glsl"

Visit closest_visit() { return Visit(3e38, NO_TRIANGLE, vec2(0.0)); }
