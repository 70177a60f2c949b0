// As passes/seen_pixels.glsl, where more than cloth hides light. A ground hides what comes from below the horizon, and the
// nine parts of the broad light tell of what comes from above, so that the horizon does not blur into the shadows of the
// cloth; and what comes back from cloth, objects and ground is known.
#include "passes/gbuffer.glsl"
#define look_from look_from_pixel
#define V_broad V_broad_above
#define with_bounce with_own_bounce
#include "passes/seen_pixels.glsl"
#undef look_from
#undef V_broad
#undef with_bounce
layout(binding = 15) uniform sampler2D bounced_light;  // passes/bounce_pixels.comp
uniform bool over_ground;
const float HORIZON = 0.4;  // of the sine of the height: so softly the few directions of a lobe pass from hidden to seen
vec3 up;                    // in the surface frame

void look_from(ivec2 pixel) {
    look_from_pixel(pixel);
    up = surface_from_world_at(pixel)[1];
}

float V_broad(vec3 omega) {
    float above = over_ground ? clamp(0.5 + dot(omega, up) / HORIZON, 0.0, 1.0) : 1.0;
    return above * V_broad_above(omega);
}

vec3 with_bounce(vec3 L) { return L + albedo * texelFetch(bounced_light, seen_from, 0).rgb; }
