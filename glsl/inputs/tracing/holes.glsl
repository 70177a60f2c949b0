// Where the cloth of a grid has holes near by: a map of one repeat of its weave, averaged over what a pixel covers.   [own]
// Define: HOLES, where this file is included. See glcloth/tracing/threads.py.
#include "woven/sheet.glsl"
#ifdef FABRICS
// Each fabric has its own; take_fabric says which one counts.
#include "inputs/tracing/fabrics.glsl"
uniform sampler2DArray hole_map;     // 1 in holes; a layer a fabric
uniform vec4 hole_of[FABRICS];       // what hole_repeats, hole_mean and far_footprint are of one fabric
uniform ivec3 hole_grids[FABRICS];   // as hole_grid
uniform vec2 quad_sizes[FABRICS];
#define hole_repeats hole_of[fabric_number].xy
#define hole_mean hole_of[fabric_number].z
#define far_footprint hole_of[fabric_number].w
#define hole_grid hole_grids[fabric_number]
#define quad_size quad_sizes[fabric_number]
#define IN_HOLE_MAP(place) vec3(place, float(fabric_number))
#else
uniform sampler2D hole_map;  // 1 in holes
uniform float hole_mean;
uniform vec2 hole_repeats;   // 1/m, along u and v
uniform ivec3 hole_grid;     // the first triangle, quads a row, triangles of a piece of cloth
uniform vec2 quad_size;      // metres of flat cloth, along a row and down a column
uniform float far_footprint; // metres in a pixel from which on it shows no threads
#define IN_HOLE_MAP(place) place
#endif
uniform vec3 seen_from;      // the eye
uniform vec2 pixel_size;     // metres that a pixel covers: anywhere, and for each metre away
uniform vec3 shines_from;    // the lamp

float pixel_width(vec3 p) { return pixel_size.x + pixel_size.y * distance(p, seen_from); }

// Where on the flat cloth a hit lies, metres.
vec2 place_of_hit(int triangle, vec2 weights) {
    int number = (triangle - hole_grid.x) % hole_grid.z, quad = number >> 1;  // in its piece of cloth
    // Corners as passes/accel/gather_grid.comp has them.
    vec2 place = (number & 1) == 0 ? weights.yx : vec2(1.0 - weights.x, weights.x + weights.y);
    return (vec2(quad % hole_grid.y, quad / hole_grid.y) + place) * quad_size;
}

// How much cloth a square of so many metres covers that is seen at a slant.
float slanted(float width, float slant) { return width * inversesqrt(max(abs(slant), 0.1)); }

// The share of a pixel's cloth whose threads show.
float threads_shown(float width) { return clamp(2.5 - 2.5 * width / far_footprint, 0.0, 1.0); }

// The share of holes about a hit of the cloth, in a square of so many metres that is seen at a slant.
float hole_at(int triangle, vec2 weights, float width, float slant) {
    vec2 texels = slanted(width, slant) * hole_repeats * vec2(textureSize(hole_map, 0).xy);
    vec2 place = place_of_hit(triangle, weights) * hole_repeats;
    return textureLod(hole_map, IN_HOLE_MAP(place), log2(max(max(texels.x, texels.y), 1.0))).r;
}

// What covers a place of which `hole` is a hole, over what covers the whole cloth.
float yarns_at(float hole) { return (1.0 - hole) / max(1.0 - hole_mean, 1e-6); }
