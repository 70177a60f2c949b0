// Yarns hide each other from the side: where the ray through a place of the cloth's middle plane meets their heights.   [own]
// Defines: GROUPS. See glcloth/methods/relief.py.
#include "inputs/methods/levels.glsl"
uniform sampler2D height_levels;   // in units, as the maps lie in theirs; a texture of its own, since one value is read faster than four
uniform vec3 relief_heights;       // metres of a unit; the highest and the lowest place, units
uniform float relief_end;          // mip level at which yarns have no height: pixels are too coarse to tell
const float RELIEF_STEPS = 8.0;

float height_at(Level level, vec2 place) { return textureLod(height_levels, place_in(level.rect, place), 0.0).r; }

// The way from `place`, in repeats, to what is seen there from omega: its first two components along u and v.
vec2 relief_shift(vec2 place, Level level, vec3 omega) {
    float left = clamp(0.5 * (relief_end - level.level), 0.0, 1.0);
    vec2 way = relief_way(omega) * (left * relief_heights.x) * weave_repeats;
    float z = relief_heights.y, down = (relief_heights.z - z) / RELIEF_STEPS, n = 0.0;
    do z += down; while (height_at(level, place + way * z) < z && ++n < RELIEF_STEPS);
    // The ray meets the cloth in the last step; halved twice, so that no step shows at the edges of floats.
    down *= -0.5;
    float above = z + down;
    z = height_at(level, place + way * above) < above ? z : above;
    down *= 0.5;
    above = z + down;
    z = height_at(level, place + way * above) < above ? z : above;
    return way * z;
}
