// Cloth from afar: its sums over tangents are colours. inputs/methods/weave.glsl stands for this file, by the same name, where
// a pixel shows threads: then they are (surface, volume) of warp and of weft, whose colours come last.
#define SUMS vec3
#define ADD_LIGHT(light, omega) L += (light) * sum_tangents(vec2(0.0))
#define COLORED(sums) sums
