// How far forward (+z) another cloth hangs at a place, between the beginning and the end of a step. See
// passes/simulation/backdrop.comp, glcloth/simulation/backdrop.py.
uniform usamplerBuffer backdrop_before;
uniform usamplerBuffer backdrop_after;
uniform float backdrop_share;  // of the step that has passed
uniform vec2 backdrop_low;
uniform float backdrop_cell;
uniform ivec2 backdrop_cells;
uniform samplerBuffer rail_data;  // of each column of the cloth before it: z of its upper end at rest
uniform int columns;
uniform float row_length;         // m, from row to row

// How far forward a vertex may be pushed: where cloth behind blows out over the rail, what hangs before it would have to be
// longer than its threads are.
float backdrop_reach(int vertex) {
    return texelFetch(rail_data, vertex % columns).x + row_length * float(vertex / columns);
}

float height_of(ivec2 cell) {
    cell = clamp(cell, ivec2(0), backdrop_cells - 1);
    int k = cell.y * backdrop_cells.x + cell.x;
    return mix(uintBitsToFloat(texelFetch(backdrop_before, k).x), uintBitsToFloat(texelFetch(backdrop_after, k).x), backdrop_share);
}

// Interpolated between the cells: each of the four counts what is around it, so the mean lies before what is at p.
float backdrop_height(vec3 p) {
    vec2 at = (p.xy - backdrop_low) / backdrop_cell - 0.5;
    ivec2 cell = ivec2(floor(at));
    vec2 f = at - vec2(cell);
    return mix(mix(height_of(cell), height_of(cell + ivec2(1, 0)), f.x),
               mix(height_of(cell + ivec2(0, 1)), height_of(cell + ivec2(1, 1)), f.x), f.y);
}
