// A print on the cloth of a draw: by how much the colours of its yarns are multiplied.   [own]
// glcloth/picture/prints.py fills the map.
#include "inputs/picture/pixel_uv.glsl"

uniform sampler2DArray print_map;  // one layer: the print over its mean on this cloth,
uniform vec3 print_mean;           // in which the fabric of the draw is dyed
uniform vec2 print_repeats;        // 1/m, along u and v
uniform float print_taps;          // places that are read at most

// The print over its mean, in the mean of a pixel.
vec3 print_over_mean(PixelUv at) {
    vec2 size = vec2(textureSize(print_map, 0).xy), x = at.x * print_repeats, y = at.y * print_repeats;
    vec2 taps = taps_and_level(x * size, y * size, print_taps);
    vec2 way = dot(x * size, x * size) > dot(y * size, y * size) ? x : y;
    vec3 sum = vec3(0.0);
    float tap = 0.0;
    do {
        vec2 place = at.uv * print_repeats + way * ((tap + 0.5) / taps.x - 0.5);
        sum += textureLod(print_map, vec3(place, 0.0), taps.y).rgb;
    } while (++tap < taps.x);
    return sum / taps.x;
}
