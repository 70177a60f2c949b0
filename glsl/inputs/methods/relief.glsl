// Yarns hide each other from the side: where the ray through a place of the cloth's middle plane meets their heights.   [own]
// Defines: GROUPS. See glcloth/methods/relief.py.
#include "core/footprint.glsl"
uniform sampler2DArray weave_map;  // GROUPS layers of rel, then of turn; then one whose first value is 1 in holes
uniform sampler2D height_map;      // in units; a texture of its own, since one value is read faster than four
uniform vec2 weave_repeats;        // 1/m, along u and v
uniform vec3 relief_heights;       // metres of a unit; the highest and the lowest place, units
uniform float relief_end;          // mip level at which yarns have no height: pixels are too coarse to tell
const float RELIEF_STEPS = 8.0;

float height_at(vec2 place, float level) { return textureLod(height_map, place, level).r; }

// The way from `place`, in repeats, to what is seen there from omega: its first two components along u and v.
vec2 relief_shift(vec2 place, float level, vec3 omega) {
    float left = clamp(0.5 * (relief_end - level), 0.0, 1.0);
    vec2 way = relief_way(omega) * (left * relief_heights.x) * weave_repeats;
    float z = relief_heights.y, down = (relief_heights.z - z) / RELIEF_STEPS, n = 0.0;
    do z += down; while (height_at(place + way * z, level) < z && ++n < RELIEF_STEPS);
    // The ray meets the cloth in the last step; halved twice, so that no step shows at the edges of floats.
    down *= -0.5;
    float above = z + down;
    z = height_at(place + way * above, level) < above ? z : above;
    down *= 0.5;
    above = z + down;
    z = height_at(place + way * above, level) < above ? z : above;
    return way * z;
}
