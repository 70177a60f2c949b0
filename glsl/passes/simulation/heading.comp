#version 430
// A heading that turns about its rail with the cloth below it, as tape does on gliders: the first row's wave stays across
// the way that the cloth takes away from it. One work group.
layout(local_size_x = 64) in;
layout(std430) buffer Position { vec4 x[]; };
layout(std430) buffer Heading { vec4 heading[]; };   // (angle, -), then of each column its place at rest: (x, off the axis)
uniform int columns;
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
    angle += clamp(wanted - angle, -most, most);
    for (int j = lane; j < columns; j += 64) {
        vec2 rest = heading[1 + j].xy;
        x[j] = vec4(rest.x, axis.x + rest.y * sin(angle), axis.y + rest.y * cos(angle), x[j].w);
    }
    barrier();
    if (lane == 0) heading[0].x = angle;
}
