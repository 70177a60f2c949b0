// The sphere in cells of an equirectangular map, as core/equirect.glsl has it.   Twin: glcloth/twins/sky_cells.py
#include "core/math.glsl"

// [own]  The direction at a place (0 to 1 across and down) in a cell; equal areas of it are equal solid angles.
vec3 cell_direction(int cell, int width, int height, vec2 place) {
    int row = cell / width;
    float phi = 2.0 * PI * (float(cell - row * width) + place.x) / float(width);
    // The versed sine keeps the digits at the zenith, and by symmetry at the nadir.
    bool upper = 2 * row < height;
    float edge = PI / float(height) * float(upper ? row : height - 1 - row);
    float from = sin(0.5 * edge), to = sin(0.5 * edge + 0.5 * PI / float(height));
    float below = 2.0 * mix(from * from, to * to, upper ? place.y : 1.0 - place.y);
    float s = sqrt(max(below * (2.0 - below), 0.0));
    return vec3(s * sin(phi), upper ? 1.0 - below : below - 1.0, -s * cos(phi));
}
