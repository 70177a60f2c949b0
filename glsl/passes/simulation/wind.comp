#version 430
// Force of the air on every triangle. One invocation per quad, two triangles each.
#include "simulate/wind.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform samplerBuffer Position;
uniform samplerBuffer Velocity;
layout(std430) writeonly buffer AirForce { vec4 F[]; };
uniform int rows;
uniform int columns;
uniform float h;            // s, for how long the force will act
uniform float time;
uniform vec3 wind;           // mean velocity of the air, m/s
uniform float gustiness;     // 0 = steady
uniform float C_n;
uniform float C_t;
uniform float triangle_mass; // kg

vec4 air_force(int i_0, int i_1, int i_2) {
    vec3 p_0 = texelFetch(Position, i_0).xyz;
    vec3 p_1 = texelFetch(Position, i_1).xyz;
    vec3 p_2 = texelFetch(Position, i_2).xyz;
    vec3 air = wind * gust((p_0 + p_1 + p_2) / 3.0, time, wind, gustiness);
    vec3 v_rel = air - (texelFetch(Velocity, i_0).xyz + texelFetch(Velocity, i_1).xyz + texelFetch(Velocity, i_2).xyz) / 3.0;
    vec3 S = 0.5 * cross(p_1 - p_0, p_2 - p_0);
    return vec4(drag_limited(drag(v_rel, S, C_n, C_t), v_rel, triangle_mass, h), 0.0);
}

void main() {
    int quad = item();
    if (quad >= (rows - 1) * (columns - 1)) {
        return;
    }
    int i = quad / (columns - 1);
    int j = quad - i * (columns - 1);
    int a = i * columns + j;
    int b = a + 1;
    int c = a + columns;
    int d = c + 1;
    bool even = ((i + j) & 1) == 0;
    F[2 * quad] = air_force(a, c, even ? d : b);
    F[2 * quad + 1] = air_force(even ? a : b, even ? d : c, even ? b : d);
}
