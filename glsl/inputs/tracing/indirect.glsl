// Light that comes from the room, the curtain and the sky, and not straight from the lamp: irradiance, from the texels that
// glcloth/curtain/radiosity.py makes each frame.
const int SHEET_GRID = 40;  // parts of the sheet; borders of its cells lie at some
uniform usamplerBuffer chart_of;       // of each triangle of the room
uniform samplerBuffer chart_data;      // three texels a chart: (origin, first texel) and twice (gradient, cells)
uniform samplerBuffer light_texels;    // of the charts, then of the curtain: for front and back, cell by cell, azimuths
uniform int sheet_texels;              // the first of the curtain's
uniform vec4 sheet_place;              // its least x and y; 1 / width, 1 / height
uniform ivec2 sheet_cells;
uniform samplerBuffer sheet_grid;      // in cells, at every 1 / 40 of it, across and up
uniform float sheet_azimuth;           // sine of the azimuths to either side

vec3 indirect_on_solid(int triangle, vec3 p, vec3 N_g) {
    int chart = int(texelFetch(chart_of, triangle).x);
    vec4 a = texelFetch(chart_data, 3 * chart);
    vec4 u = texelFetch(chart_data, 3 * chart + 1);
    vec4 v = texelFetch(chart_data, 3 * chart + 2);
    vec2 cells = vec2(u.w, v.w);
    // A rim of one texel lies round the cells.
    vec2 at = clamp(vec2(dot(p - a.xyz, u.xyz), dot(p - a.xyz, v.xyz)) * cells + 0.5, vec2(0.0), cells + 0.999);
    ivec2 i = ivec2(at);
    vec2 f = at - vec2(i);
    int across = int(u.w) + 2;
    int k = int(a.w) + i.y * across + i.x;
    vec3 low = mix(texelFetch(light_texels, k).rgb, texelFetch(light_texels, k + 1).rgb, f.x);
    vec3 high = mix(texelFetch(light_texels, k + across).rgb, texelFetch(light_texels, k + across + 1).rgb, f.x);
    return mix(low, high, f.y);
}

// Of a cell and a side, for the azimuth s (-1 to 1).
vec3 sheet_light(int cell, float s) {
    int k = sheet_texels + 3 * cell + 1;
#ifdef FABRICS
    // Of two curtains each has its own.
    k += 6 * sheet_cells.x * sheet_cells.y * (fabric_first / fabric_stride);
#endif
    return mix(texelFetch(light_texels, k).rgb, texelFetch(light_texels, s < 0.0 ? k - 1 : k + 1).rgb, abs(s));
}

// A place on the sheet, in cells.
vec2 sheet_cell_at(vec2 place) {
    vec2 at = clamp(place, vec2(0.0), vec2(1.0)) * float(SHEET_GRID);
    ivec2 i = min(ivec2(at), SHEET_GRID - 1);
    vec2 f = at - vec2(i);
    return vec2(mix(texelFetch(sheet_grid, i.x).x, texelFetch(sheet_grid, i.x + 1).x, f.x),
                mix(texelFetch(sheet_grid, i.y).y, texelFetch(sheet_grid, i.y + 1).y, f.y));
}

// On the side of the curtain that N points to.
vec3 sheet_light_at(vec3 p, vec3 N) {
    float s = clamp(N.x / sheet_azimuth, -1.0, 1.0);
    vec2 last = vec2(sheet_cells - 1);
    vec2 at = clamp(sheet_cell_at((p.xy - sheet_place.xy) * sheet_place.zw) - 0.5, vec2(0.0), last);
    ivec2 i = ivec2(at);
    ivec2 j = min(i + 1, sheet_cells - 1);
    vec2 f = at - vec2(i);
    int side = N.z > 0.0 ? 0 : sheet_cells.x * sheet_cells.y;
    vec3 low = mix(sheet_light(side + i.y * sheet_cells.x + i.x, s), sheet_light(side + i.y * sheet_cells.x + j.x, s), f.x);
    vec3 high = mix(sheet_light(side + j.y * sheet_cells.x + i.x, s), sheet_light(side + j.y * sheet_cells.x + j.x, s), f.x);
    return mix(low, high, f.y);
}

// On the side that N points to, and on the other one.
void indirect_on_cloth(int triangle, vec2 weights, vec3 p, vec3 N, out vec3 E, out vec3 E_behind) {
    E = sheet_light_at(p, N);
    E_behind = sheet_light_at(p, -N);
}
