#version 430
// Copies a traced picture for the window: pixels without a sample show the picture before, of whatever size that is.
layout(std430) readonly buffer Picture { vec4 picture[]; };  // sum / samples in all; samples added
uniform sampler2D shown;
uniform ivec2 size;
uniform float samples;  // in all
out vec4 color;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 sum = picture[(size.y - 1 - pixel.y) * size.x + pixel.x];
    color = vec4(sum.a > 0.0 ? sum.rgb * (samples / sum.a) : textureLod(shown, gl_FragCoord.xy / vec2(size), 0.0).rgb, 1.0);
}
