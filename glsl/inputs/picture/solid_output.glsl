// What a pixel of the objects and the ground gives out, and its kinds of light apart in programs with PARTS.
uniform float pass_weight;    // share of this sample in the pixel
uniform float pass_cover;     // what this pass adds to the pixel's coverage: the first all
#ifdef CATCHER
#include "inputs/picture/catcher.glsl"
#endif

void put(ivec2 pixel, int triangle, vec3 L, vec3 radiance_per_irradiance) {
    color = vec4(L * pass_weight, pass_cover);
#ifdef PARTS
    bounce_color = vec4(radiance_per_irradiance * L_bounce * pass_weight, 0.0);
    through_color = vec4(0.0);
#endif
#ifdef CATCHER
    if (triangle < first_catching) return;
    color = caught(pixel, pass_weight);
#ifdef PARTS
    bounce_color = vec4(0.0);
#endif
#endif
}
