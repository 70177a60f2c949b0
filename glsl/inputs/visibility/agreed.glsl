// Whether the pixels about a pixel found of a sun what it found.
// Needs frame_N of inputs/picture/gbuffer.glsl, AGREE of inputs/visibility/sun_points.glsl.
uniform sampler2DArray first_seen;  // what a ray from each pixel found; 0 where there is nothing

// How far apart they are, in each channel of a layer.
vec4 apart(ivec2 pixel, int layer, vec4 own) {
    vec4 low = own, high = own;
    ivec2 last = textureSize(frame_N, 0) - 1;
    for (int n = 0; n < 9; ++n) {
        ivec2 at = clamp(pixel + ivec2(n % 3, n / 3) - 1, ivec2(0), last);
        if (texelFetch(frame_N, at, 0).w == 0.0) continue;
        vec4 other = texelFetch(first_seen, ivec3(at, layer), 0);
        low = min(low, other);
        high = max(high, other);
    }
    return high - low;
}
