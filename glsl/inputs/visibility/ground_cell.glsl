// The vertices of the ground about a point of it.
#include "trace/ground.glsl"
uniform vec2 ground_middle;  // x, z
uniform float ground_scale;
uniform int ground_rings;
uniform int ground_sectors;
uniform int ground_first;    // number of the ground's first vertex; negative: there is no ground

int ground_vertex(int ring, int sector) {
    return ground_first + (ring == 0 ? 0 : 1 + ground_sectors * (ring - 1) + sector % ground_sectors);
}

// The four vertices about a point, and their weights.
ivec4 ground_cell(vec3 x, out vec4 weights) {
    vec2 place = ground_place(x.xz - ground_middle, ground_scale, float(ground_rings), float(ground_sectors));
    int ring = min(int(place.x), ground_rings - 1), sector = int(place.y);
    vec2 f = clamp(place - vec2(ring, sector), 0.0, 1.0);
    weights = vec4((1.0 - f.x) * vec2(1.0 - f.y, f.y), f.x * vec2(1.0 - f.y, f.y));
    return ivec4(ground_vertex(ring, sector), ground_vertex(ring, sector + 1), ground_vertex(ring + 1, sector),
        ground_vertex(ring + 1, sector + 1));
}
