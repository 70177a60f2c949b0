// The rays that a pass casts: the heads of a generation, as the GPU counts them.
#include "inputs/tracing/counts.glsl"
#define ray_count int(count[CAST])
#define first_ray int(count[FIRST_HEAD])
