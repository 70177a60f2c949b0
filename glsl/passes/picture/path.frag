#version 430
// The mean of what the path tracer has added up; alpha: how much of a pixel surfaces cover.
layout(std430) readonly buffer Sums { vec4 sums[]; };  // three a pixel, see passes/tracing/path.comp
uniform ivec2 size;
uniform float samples;
out vec4 color;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    int i = 3 * (pixel.y * size.x + pixel.x);
    color = vec4(sums[i].rgb, sums[i + 1].w) / samples;
}
