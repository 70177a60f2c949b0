// What a ray meets, where nothing lets light through: "sight.glsl" of a pass.
#include "inputs/accel/ray.glsl"
#include "inputs/accel/visit_any.glsl"
#include "accel.glsl"
