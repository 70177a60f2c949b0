#version 430
// Means over a repeat of what the maps of threads show from a direction, where yarns hide each other.   [own]
// Defines: GROUPS, EACH_GROUP(F). An invocation makes those of one direction and mip level. See glcloth/methods/relief.py.
#include "core/math.glsl"
#include "core/disk.glsl"
#include "inputs/methods/relief.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
layout(std430) writeonly buffer Means { vec4 mean[]; };  // [2 GROUPS + 1, levels, side, side]
uniform int table_side;
uniform int levels;
uniform int first_level;  // the mip level of the first
uniform int per_level;    // how many from one mip level to the next
uniform int sample_count;  // of the finest mip level; of all others half as many

vec4 rel_sum[GROUPS], turn_sum[GROUPS];

void main() {
    int texels = table_side * table_side, i = item();
    if (i >= texels * levels) return;
    int row = i / texels, at = i % texels, n = 0;
    float lod = float(first_level) + float(row) / float(per_level);
    vec2 p = 2.0 * vec2(at % table_side, at / table_side) / float(table_side - 1) - 1.0;
    vec3 omega = from_disk(p);
    // Two texels beyond the horizon nothing is read.
    int count = length(p) > 1.0 + 4.0 / float(table_side - 1) ? 1 : max(sample_count >> (row / per_level), sample_count / 2);
    float hole = 0.0;
    // Errors of neighbouring directions differ, so that they cancel where the table is interpolated.
    vec2 start = fract(float(i) * vec2(0.6180339887, 0.4142135624));
#define NONE(g) rel_sum[g] = turn_sum[g] = vec4(0.0);
    EACH_GROUP(NONE)
    do {
        // A lattice that runs in step with no yarns.
        vec2 place = fract(start + float(n) * R2);
        // Between two versions the mean is that of both, as it is in pictures.
        vec2 number = level_number(lod, weave_steps, fract(start.x + 0.7548776662 * float(n) + 0.5));
        Level level = weave_level(number.x + (fract(start.y + 0.4450418680 * float(n)) < number.y ? 1.0 : 0.0));
        place += relief_shift(place, level, omega);
#define ADD(g) rel_sum[g] += weave_at(level, place, g); \
        turn_sum[g] += weave_at(level, place, g + GROUPS);
        EACH_GROUP(ADD)
        hole += weave_at(level, place, 2 * GROUPS).r;
    } while (++n < count);
    float share = 1.0 / float(n);
#define STORE(g) mean[i + texels * levels * g] = share * rel_sum[g]; \
    mean[i + texels * levels * (g + GROUPS)] = share * turn_sum[g];
    EACH_GROUP(STORE)
    mean[i + texels * levels * 2 * GROUPS] = vec4(share * hole);
}
