// Up to four grids of cloth laid flat beyond the scene, where neighbours on the cloth are neighbours and areas are the cloth's,
// however it hangs: side by side, their fronts in the plane z = flat_far, their backs in z = -flat_far. Needs corner_data of inputs/tracing/surface_at.glsl.
uniform ivec4 flat_first;    // the first triangle of each; two triangles a quad, row by row, as passes/accel/gather_grid.comp
uniform ivec4 flat_columns;  // quads across
uniform vec4 flat_across;    // spacing of the grids,
uniform vec4 flat_down;
uniform vec4 flat_begin;     // and where they begin along x
uniform float flat_far;

struct FlatPlace {
    vec3 p;
    vec3 n;
    int side;   // 0: front
    int piece;
};

// The normal of a triangle's front, of any length.
vec3 side_of(int triangle) {
    vec3 a = uintBitsToFloat(texelFetch(corner_data, 3 * triangle).xyz);
    vec3 b = uintBitsToFloat(texelFetch(corner_data, 3 * triangle + 1).xyz);
    vec3 c = uintBitsToFloat(texelFetch(corner_data, 3 * triangle + 2).xyz);
    return cross(b - a, c - a);
}

FlatPlace flat_place(int triangle, vec2 at, vec3 toward) {
    int piece = int(triangle >= flat_first.y) + int(triangle >= flat_first.z) + int(triangle >= flat_first.w);
    int t = triangle - flat_first[piece];
    int quad = t / 2;
    int row = quad / flat_columns[piece];
    vec2 corner = vec2(float(quad - row * flat_columns[piece]), float(row));
    // The corners are (0, 0), (0, 1), (1, 0) of the quad, and (1, 0), (0, 1), (1, 1).
    vec2 inside = (t & 1) == 0 ? vec2(at.y, at.x) : vec2(1.0 - at.x, at.x + at.y);
    float side = dot(side_of(triangle), toward) < 0.0 ? -1.0 : 1.0;
    vec2 place = vec2(flat_across[piece], flat_down[piece]) * (corner + inside);
    // From behind it is seen the other way round, as any surface.
    vec3 p = vec3(flat_begin[piece] + place.x, -place.y, side * flat_far);
    return FlatPlace(p, vec3(0.0, 0.0, side), side < 0.0 ? 1 : 0, piece);
}
