// As passes/seen_pixels.glsl, over a ground: it hides what comes from below the horizon, and the nine parts of the broad
// light tell of what comes from above. So the horizon does not blur into the shadows of the cloth.
#include "passes/gbuffer.glsl"
#define look_from look_from_pixel
#define V_broad V_broad_above
#include "passes/seen_pixels.glsl"
#undef look_from
#undef V_broad
const float HORIZON = 0.4;  // of the sine of the height: so softly the few directions of a lobe pass from hidden to seen
vec3 up;                    // in the surface frame

void look_from(ivec2 pixel) {
    look_from_pixel(pixel);
    up = surface_from_world_at(pixel)[1];
}

float V_broad(vec3 omega) { return V_broad_above(omega) * clamp(0.5 + dot(omega, up) / HORIZON, 0.0, 1.0); }
