#version 430
// A hair where it stands out beyond the cloth's outline. Right before the cloth it is part of what the cloth reflects: there it
// only makes it lighter or darker, by a factor of mean 1.   [own]
// The picture becomes color + (1 - hidden) times what it was.
#include "fibre/hair.glsl"
uniform sampler2D nearest;   // depth of all that is drawn
uniform sampler2D own_depth; // of the cloth
uniform sampler2D frame_N;
uniform sampler2D frame_p;
uniform vec4 viewpoint;
uniform vec2 clear_way;      // metres in front of the cloth, from which on a hair shows, and is shown whole
in vec3 place;
in vec3 radiance;
in float across;
in float wide;
flat in float lighter;
const float OUTSIDE = 0.35, INSIDE = 0.3;  // how much lighter or darker hairs are
layout(location = 0, index = 0) out vec4 color;
layout(location = 0, index = 1) out vec4 hidden;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(nearest, pixel, 0).r;
    if (gl_FragCoord.z > depth) discard;
    float share = hair_cover(across, wide), within = 0.0;
    if (texelFetch(frame_N, pixel, 0).w != 0.0 && texelFetch(own_depth, pixel, 0).r <= depth) {
        vec3 behind = texelFetch(frame_p, pixel, 0).xyz;
        float way = viewpoint.w > 0.0 ? distance(behind, viewpoint.xyz) - distance(place, viewpoint.xyz)
            : dot(place - behind, viewpoint.xyz);
        float clear = smoothstep(clear_way.x, clear_way.y, way);
        within = (1.0 - clear) * share;
        share *= clear;
    }
    color = vec4((1.0 + OUTSIDE * lighter) * share * radiance, share);
    // Where the cloth covers a part of the pixel, lighter cloth covers no other part.
    hidden = vec4(vec3(share - INSIDE * lighter * within), share);
}
