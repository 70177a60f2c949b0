// Where on its threads a sample of a pixel lies. Stands for inputs/picture/pixel_uv.glsl in the path tracer, which asks there for
// no pixel but for the place that its path has come to.   [own]
#include "inputs/picture/uv_footprint.glsl"

PixelUv place_of_path;

PixelUv pixel_uv(ivec2 pixel) { return place_of_path; }
