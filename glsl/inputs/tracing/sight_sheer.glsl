// What is seen along a ray, where cloth lets light through: the nearest hit, or the layers of cloth in its way.
#include "inputs/accel/ray.glsl"
#include "inputs/tracing/visit_sheer.glsl"
#include "accel.glsl"
#include "inputs/visibility/sheet_at.glsl"
