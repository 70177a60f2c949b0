#version 430
// Between two substeps. Finish the last one: solids push the cloth out, friction holds it, and the velocity follows
// from the motion. Begin the next: acceleration changes the velocity, the velocity moves the vertex.
// One invocation per vertex. Defines: FINISH, BEGIN, CONTACT (0 or 1): a software rasteriser executes every branch,
// taken or not, so unwanted code must not be compiled. "solids.glsl" is written by glcloth/simulation/cloth.py: one
// call of `resolve` for each solid.
#include "simulate/collide.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
layout(std430) buffer Position { vec4 x[]; };       // xyz m, w = inverse mass 1/kg
layout(std430) buffer Previous { vec4 p[]; };       // x at the start of the substep
layout(std430) buffer Velocity { vec4 v[]; };       // m/s, within a substep as it was predicted
layout(std430) readonly buffer Air { vec4 air[]; }; // acceleration by the air, m/s^2
layout(std430) readonly buffer Contact { vec4 shift[]; };
uniform int vertex_count;
uniform float h;
uniform vec3 gravity;
uniform float speed_limit;
uniform float thickness;     // m, kept between the cloth and a solid
uniform float mu;            // friction coefficient
uniform float keep;          // share of the velocity that damping leaves in one substep

// The point pushed out of one solid whose (gradient, distance) at the point is `surface`, and held by friction.
vec3 resolve(vec3 point, vec3 before, vec4 surface) {
    float push = thickness - surface.w;
    if (push <= 0.0) {
        return point;
    }
    point += push * surface.xyz;
    vec3 moved = point - before;
    return point + friction(moved - dot(moved, surface.xyz) * surface.xyz, push, mu);
}

#include "solids.glsl"

void main() {
    int index = item();
    if (index >= vertex_count) {
        return;
    }
    vec4 position = x[index];
    vec3 point = position.xyz;
    vec3 velocity = v[index].xyz;
    float moves = position.w > 0.0 ? 1.0 : 0.0;
#if FINISH == 1
    vec3 before = p[index].xyz;
#if CONTACT == 1
    point += moves * shift[index].xyz;
#endif
    vec3 resolved = resolve_solids(point, before);
    point = position.w > 0.0 ? resolved : point;
    // Only the correction changes the velocity: (point - before) / h would round a whole step's way to the grid of
    // float32, which at h = 0.4 ms is a few per cent of gravity.
    velocity = moves * keep * (velocity + (point - (before + h * velocity)) / h);
#endif
#if BEGIN == 1
    p[index] = vec4(point, position.w);
    velocity += moves * h * (gravity + air[index].xyz);
    velocity *= min(1.0, speed_limit / max(length(velocity), 1e-9));
    point += h * velocity;
#endif
    v[index] = vec4(velocity, 0.0);
    x[index] = vec4(point, position.w);
}
