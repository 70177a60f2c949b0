// Printed cloth whose threads are too fine to be seen: all tangents as they are, in the colours of the print.   [own]
// Stands for inputs/methods/threads.glsl, as inputs/methods/weave.glsl does where threads are seen, and has its names.
#include "inputs/methods/rel.glsl"
#include "inputs/picture/print.glsl"
#define SUMS vec4
#define ADD_LIGHT(light, omega) L += (light) * woven(sum_tangents(vec2(0.0)))
#define COLORED(sums) woven(sums)

uniform vec3 weave_A[2];
vec3 pixel_A[2];
const vec4 strands = vec4(1.0);

void fetch_weave(ivec2 pixel) {
#define EVERY_REL(g) rel[g] = vec4(1.0); turn[g] = vec4(0.0);
    EACH_GROUP(EVERY_REL)
    vec3 ink = print_over_mean(pixel_uv(pixel));
    pixel_A[0] = weave_A[0] * ink;
    pixel_A[1] = weave_A[1] * ink;
}

// The colour of sums of surface and volume terms, of warp and of weft.
vec3 woven(vec4 sums) { return sums.x + pixel_A[0] * sums.y + sums.z + pixel_A[1] * sums.w; }
#include "inputs/methods/even.glsl"
