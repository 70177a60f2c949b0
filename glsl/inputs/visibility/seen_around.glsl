// As inputs/visibility/seen_pixels.glsl, where more than cloth hides light. A ground hides what comes from below the horizon, and the
// nine parts of the broad light tell of what comes from above, so that the horizon does not blur into the shadows of the
// cloth; and what comes back from cloth, objects and ground is known.
#include "core/math.glsl"
#include "inputs/picture/gbuffer.glsl"
#define look_from look_from_pixel
#define V_broad V_broad_above
#define with_bounce with_own_bounce
#include "inputs/visibility/seen_pixels.glsl"
#undef look_from
#undef V_broad
#undef with_bounce
layout(binding = 15) uniform sampler2DArray bounced_light;  // passes/visibility/bounce_pixels.comp
layout(binding = 14) uniform sampler2DArray views;          // passes/methods/furnace_views.comp
uniform bool over_ground;
const float HORIZON = 0.4;  // of the sine of the height: so softly the few directions of a lobe pass from hidden to seen,
                            // where the horizon of the world goes through the hemisphere
vec3 up;                    // in the surface frame
float softness;
vec3 viewer;                // likewise
mat3 surface_from_world_here;

void look_from(ivec2 pixel) {
    look_from_pixel(pixel);
    surface_from_world_here = surface_from_world_at(pixel);
    up = surface_from_world_here[1];
    softness = HORIZON * length(up.xy) + 1e-3;
    viewer = surface_from_world_here * omega_o_at(vec2(pixel) + 0.5);
}

float V_broad(vec3 omega) {
    float above = over_ground ? clamp(0.5 + dot(omega, up) / softness, 0.0, 1.0) : 1.0;
    return above * V_broad_above(omega);
}

// What comes back is light from all over the hemisphere, more of it from its mean direction: the fabric gives back of it
// what it does of a white furnace toward the viewer, and as much more or less as its first moment says.
vec3 with_bounce(vec3 L) {
    if (albedo == vec3(0.0)) return L;
    vec3 back = texelFetch(bounced_light, ivec3(seen_from, 0), 0).rgb;
    vec2 from = (surface_from_world_here * texelFetch(bounced_light, ivec3(seen_from, 1), 0).xyz).xy
        / max(dot(back, vec3(0.2126, 0.7152, 0.0722)), 1e-12);
    vec2 place = vec2(atan(viewer.y, viewer.x) / (2.0 * PI), viewer.z);
    vec4 furnace = textureLod(views, vec3(place, 0.0), 0.0);
    float lean = dot(vec2(furnace.a, textureLod(views, vec3(place, 1.0), 0.0).r), from);
    return L + back * furnace.rgb * max(1.0 + lean, 0.0);
}
