// The maps of threads and of their colours, in versions of which a pixel reads one: see glcloth/weave/levels.py.   [own]
#include "core/footprint.glsl"
const int MOST_LEVELS = 40;

uniform sampler2DArray weave_levels;  // GROUPS layers of rel, then of turn; then one whose first value is 1 in holes
uniform vec4 weave_rects[MOST_LEVELS];  // where each version lies in the picture
uniform vec2 weave_sizes;  // texels of the first, along u and v
uniform vec3 weave_steps;  // see level_number
uniform vec2 weave_repeats;  // 1/m, along u and v
uniform sampler2DArray color_levels;  // of warp and of weft: colour times share, share
uniform vec4 color_rects[MOST_LEVELS];
uniform vec2 color_sizes;
uniform vec3 color_steps;
uniform vec2 color_repeats;  // 1/m

struct Level {
    vec4 rect;    // where it lies
    float level;  // as mip levels are counted
};

Level weave_level(float number) { return Level(weave_rects[int(number)], level_of_number(number, weave_steps)); }

vec4 weave_at(Level level, vec2 place, int layer) {
    return textureLod(weave_levels, vec3(place_in(level.rect, place), float(layer)), 0.0);
}

vec4 color_at(float number, vec2 place, int yarn) {
    return textureLod(color_levels, vec3(place_in(color_rects[int(number)], place), float(yarn)), 0.0);
}
