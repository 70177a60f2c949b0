// Between the pixels of a coarse picture: what their neighbours make of them, and whether that is good enough.   [own]
#include "inputs/picture/gbuffer.glsl"
uniform sampler2D coarse;  // every pixel of these is one of the picture,
uniform int coarse_stride; // so many pixels apart
uniform float tolerance;   // estimated relative error of luminance above which a pixel is shaded itself
uniform float bend_limit;  // sine of the angle between neighbours' normals above which a lobe could hide between them

const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722);

vec4 coarse_at(ivec2 p) {
    return texelFetch(coarse, clamp(p, ivec2(0), textureSize(coarse, 0) - 1), 0);
}

vec4 frame_at(ivec2 coarse_pixel) {
    return texelFetch(frame_N, min(coarse_stride * coarse_pixel, textureSize(frame_N, 0) - 1), 0);
}

// The value half way between `low` and low + d by the two before and the two behind it; alpha < 0: not to be trusted.
vec4 between(ivec2 low, ivec2 d, vec4 N) {
    vec4 a = coarse_at(low), b = coarse_at(low + d), before = coarse_at(low - d), after = coarse_at(low + 2 * d);
    // Beyond an edge of the cloth the curve goes on as it came.
    vec4 bend = before.a > 0.0 ? before - 2.0 * a + b : after.a > 0.0 ? a - 2.0 * b + after : vec4(0.0);
    if (before.a == 0.0) before = 2.0 * a - b + bend;
    if (after.a == 0.0) after = 2.0 * b - a + bend;
    vec4 bend_a = before - 2.0 * a + b, bend_b = a - 2.0 * b + after;
    vec4 middle = 0.5 * (a + b) - (bend_a + bend_b) / 16.0;
    float l_a = dot(a.rgb, LUMINANCE), l_b = dot(b.rgb, LUMINANCE);
    float B_a = dot(bend_a.rgb, LUMINANCE), B_b = dot(bend_b.rgb, LUMINANCE);
    // A curve bends alike at both; where a shadow's edge passes between they are opposite and as large as the step.
    float doubt = max(max(abs(B_a), abs(B_b)) / 16.0, abs(B_a - B_b) / 8.0);
    vec4 N_a = frame_at(low), N_b = frame_at(low + d);
    // The normal itself is known everywhere. Radiance follows it, so the normal's distance from its neighbours'
    // mean, in units of their difference, tells the share of the radiance's difference that interpolation misses.
    vec3 step_N = N_b.xyz - N_a.xyz, off = N.xyz - 0.5 * (N_a.xyz + N_b.xyz);
    float missed = abs(l_a - l_b) * length(off) / (length(step_N) + 1e-4);
    bool same = N_a.w == N.w && N_b.w == N.w;
    bool good = same && dot(step_N, step_N) < bend_limit * bend_limit && dot(off, off) < 0.04 * bend_limit * bend_limit
        && max(doubt, missed) <= tolerance * min(l_a, l_b);
    return vec4(max(middle.rgb, min(a.rgb, b.rgb) * 0.5), good ? a.a : -1.0);
}

// The value of a place between `low` and its neighbours, where it is odd; `odd` is not 0. alpha <= 0: not good enough.
vec4 interpolated(ivec2 low, ivec2 odd, vec4 N) {
    // Between two neighbours the line through them, between four both diagonals.
    bool diagonal = odd.x + odd.y == 2;
    vec4 first = between(low, odd, N);
    vec4 second = between(diagonal ? low + ivec2(0, 1) : low, diagonal ? ivec2(1, -1) : odd, N);
    vec4 mean = 0.5 * (first + second);
    float apart = abs(dot(first.rgb - second.rgb, LUMINANCE));
    bool good = min(first.a, second.a) > 0.0 && apart <= 4.0 * tolerance * dot(mean.rgb, LUMINANCE);
    return vec4(mean.rgb, good ? first.a : -1.0);
}
