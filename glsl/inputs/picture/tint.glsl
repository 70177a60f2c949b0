// What a print leaves of the light that comes through the yarns of a pixel.   [own]
#ifdef PRINT
#include "inputs/picture/print.glsl"
vec3 tint_at(ivec2 pixel) { return min(print_mean * print_over_mean(pixel_uv(pixel)), vec3(1.0)); }
#endif
