// The light from far away: a map without its suns, drawn by cells of it as bright as they are.
#include "core/equirect.glsl"
#include "trace/sky_cells.glsl"
uniform sampler2D sky_map;
uniform samplerBuffer sky_cells;  // of each cell how often it keeps a draw, the cell that else gets it, and its density
uniform ivec2 sky_size;           // cells across and down
uniform mat3 environment_from_world;

// Radiance, and the density of `sky_direction` per solid angle.
vec3 sky_radiance(vec3 from, vec3 omega, out float pdf) {
    vec2 uv = uv_from_direction(normalize(environment_from_world * omega));
    ivec2 at = min(ivec2(uv * vec2(sky_size)), sky_size - 1);
    pdf = texelFetch(sky_cells, at.y * sky_size.x + at.x).z;
    return textureLod(sky_map, uv, 0.0).rgb;
}

// By two numbers that choose, and two that place.   [Walker 1977, "the alias method"]
vec3 sky_direction(vec3 from, vec2 choice, vec2 place) {
    int cells = sky_size.x * sky_size.y;
    int cell = min(int(choice.x * float(cells)), cells - 1);
    vec4 kept = texelFetch(sky_cells, cell);
    cell = choice.y < kept.x ? cell : int(kept.y);
    return transpose(environment_from_world) * cell_direction(cell, sky_size.x, sky_size.y, place);
}
