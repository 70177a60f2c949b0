// Visibility of each light from a pixel, four values a texel, in this order: V_0, V_1 .. V_K, the top of the broad
// light, then from a whole texel on the rest of it (four of the low band, four of the middle one), then the suns.
#include "trace/visibility.glsl"
uniform sampler2DArray seen;  // passes/visibility/pixels.comp
uniform int top_number;
uniform int broad_number;  // of the low band's first, a multiple of 4
uniform int sun_number;    // of the first sun, likewise
uniform vec3 albedo;       // of the fabric, bihemispherical
ivec2 seen_pixel;
vec4 V_low, V_middle, V_four;
float V_top;
int four;

vec4 V_texel(int layer) { return texelFetch(seen, ivec3(seen_pixel, layer), 0); }

// Consecutive numbers share a texel, which is fetched once.
float V_number(int n) {
    if (n >> 2 != four) {
        four = n >> 2;
        V_four = V_texel(four);
    }
    vec2 pair = (n & 2) != 0 ? V_four.zw : V_four.xy;
    return (n & 1) != 0 ? pair.y : pair.x;
}

void fetch_layers(ivec2 pixel) {
    seen_pixel = pixel;
    V_low = V_texel(broad_number >> 2);
    V_middle = V_texel((broad_number >> 2) + 1);
    four = -1;
    V_top = V_number(top_number);
}

float V_gaussian(int k) { return V_number(1 + k); }

float V_sun(int s) { return V_number(sun_number + s); }

// Of the light that is summed over several Gaussians, from a direction of the surface frame.
float V_parts(vec3 omega) { return from_bands(omega, V_low, V_middle, V_top); }
