// What is seen along a ray, where no cloth lets light through: the nearest hit, or whether there is any.
#include "inputs/accel/ray.glsl"
#include "inputs/tracing/visit_either.glsl"
#include "accel.glsl"
