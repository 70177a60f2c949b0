#version 430
// A heading that turns about its rail with the cloth below it, as tape does on gliders: the wave of the first rows stays across
// the way that the cloth takes away from it. One work group.
#include "core/math.glsl"
layout(local_size_x = 64) in;
layout(std430) buffer Position { vec4 x[]; };
layout(std430) buffer Heading { vec4 heading[]; };   // (angle, -), then of each vertex of the heading its place at rest: (x, off the axis)
uniform int columns;
uniform int held;        // vertices of the heading
uniform int hanging;     // the row whose mean says where the cloth goes
uniform vec2 axis;       // of the rail: y and z
uniform float most;      // by so much it turns now at most
shared vec2 sums[64];

void main() {
    int lane = int(gl_LocalInvocationID.x);
    vec2 sum = vec2(0.0);
    for (int j = lane; j < columns; j += 64) {
        sum += x[hanging * columns + j].yz - axis;
    }
    sums[lane] = sum;
    memoryBarrierShared();
    barrier();
    for (int others = 32; others > 0; others /= 2) {
        if (lane < others) sums[lane] += sums[lane + others];
        memoryBarrierShared();
        barrier();
    }
    float angle = heading[0].x;
    float wanted = sums[0] == vec2(0.0) ? angle : atan(sums[0].y, -sums[0].x);
    // The shorter way round: atan knows angles to half a turn.
    float turn = wanted - angle - 2.0 * PI * round((wanted - angle) / (2.0 * PI));
    angle += clamp(turn, -most, most);
    float s = sin(angle), c = cos(angle);
    for (int k = lane; k < held; k += 64) {
        vec3 rest = heading[1 + k].xyz;
        x[k] = vec4(rest.x, axis.x + rest.y * c + rest.z * s, axis.y - rest.y * s + rest.z * c, x[k].w);
    }
    barrier();
    if (lane == 0) heading[0].x = angle;
}
