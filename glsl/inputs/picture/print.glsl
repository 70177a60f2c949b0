// A print on the cloth of a draw: by how much the colours of its yarns are multiplied.   [own]
// glcloth/picture/prints.py fills the map.
#include "inputs/picture/pixel_uv.glsl"

uniform sampler2DArray print_map;  // one layer: the print over its mean on this cloth,
uniform vec3 print_mean;           // in which the fabric of the draw is dyed
uniform vec2 print_repeats;        // 1/m, along u and v
uniform float print_taps;          // places that are read at most

// The print over its mean, in the mean of a pixel.
vec3 print_over_mean(PixelUv at) { return mean_of_pixel(print_map, 0.0, at, print_repeats, print_taps); }
