#version 430
// How far each column of the curtain leans into the room, in metres a metre below the rail, by least squares over its samples; as the
// weights of factors at the known leans. Behind them the mean weights of all columns.
#include "trace/form_factor.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform samplerBuffer points;      // where samples are now
uniform samplerBuffer hanging;     // column by column: z without wind, weight
uniform usamplerBuffer hung;       // which point each is
uniform usamplerBuffer columns;    // of each the first of its samples, and their number
layout(std430) writeonly buffer Leans { vec4 leans[]; };
uniform int column_count;

vec4 weights_of(int column) {
    uvec2 list = texelFetch(columns, column).xy;
    float lean = 0.0;
    for (uint k = list.x; k < list.x + list.y; ++k) {
        vec2 rest = texelFetch(hanging, int(k)).xy;
        lean += rest.y * (texelFetch(points, int(texelFetch(hung, int(k)).x)).z - rest.x);
    }
    return lean_weights(lean);
}

void main() {
    int i = item();
    if (i > column_count) return;
    if (i < column_count) {
        leans[i] = weights_of(i);
    } else {
        vec4 sum = vec4(0.0);
        int k = 0;
        do {
            sum += weights_of(k);
            ++k;
        } while (k < column_count);
        leans[i] = sum / float(column_count);
    }
}
