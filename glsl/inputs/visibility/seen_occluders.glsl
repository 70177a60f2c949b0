// As inputs/visibility/seen_pixels.glsl, with the light that surfaces send each other. A ground hides all light from below the
// horizon, and the nine parts of the broad light hold only light from above, so that the horizon does not blur into the
// shadows of the cloth; and the bounced light from all surfaces is known.
#include "core/math.glsl"
#include "inputs/picture/gbuffer.glsl"
#include "inputs/visibility/seen_layers.glsl"
uniform sampler2DArray bounced_light;  // passes/visibility/bounce_pixels.comp
uniform sampler2DArray views;          // passes/methods/furnace_views.comp
uniform bool over_ground;
const float HORIZON = 0.4;  // of the sine of the height: so softly the few directions of a lobe pass from hidden to seen,
                            // where the horizon of the world goes through the hemisphere
const float MEAN_HEIGHT = 0.5025;  // of even light's directions as passes/visibility/bounce_gather.comp weighs them: by min(100 z, 1)
vec3 up;                    // in the surface frame
float softness;
vec3 viewer;                // likewise
#ifdef WEAVE
vec3 seen_evenly();         // inputs/methods/even.glsl
#endif
mat3 seen_frame;            // the surface frame

void fetch_visibility(ivec2 pixel) {
    fetch_layers(pixel);
    seen_frame = surface_from_world_at(pixel);
    up = seen_frame[1];
    softness = HORIZON * length(up.xy) + 1e-3;
    viewer = seen_frame * omega_o_at(vec2(pixel) + 0.5);
}

float V_broad(vec3 omega) {
    float above = over_ground ? clamp(0.5 + dot(omega, up) / softness, 0.0, 1.0) : 1.0;
    return above * V_parts(omega);
}

// Bounced light comes from all over the hemisphere, more of it from its mean direction: the fabric reflects it toward
// the viewer as it does a white furnace, and as much more or less as its first moment says; a pixel that shows threads or a print
// has its share of that.
vec3 with_bounce(vec3 L) {
    if (albedo == vec3(0.0)) return L;
    vec3 back = texelFetch(bounced_light, ivec3(seen_pixel, 0), 0).rgb;
    vec3 from = seen_frame * texelFetch(bounced_light, ivec3(seen_pixel, 1), 0).xyz
        / max(dot(back, vec3(0.2126, 0.7152, 0.0722)), 1e-12);
    from.z -= MEAN_HEIGHT;
    vec2 place = vec2(atan(viewer.y, viewer.x) / (2.0 * PI), viewer.z);
    vec4 furnace = textureLod(views, vec3(place, 0.0), 0.0);
    float lean = dot(vec3(furnace.a, textureLod(views, vec3(place, 1.0), 0.0).rg), from);
    back *= furnace.rgb * max(1.0 + lean, 0.0);
#ifdef WEAVE
    back *= seen_evenly();
#endif
    return L + back;
}
