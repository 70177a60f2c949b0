#version 430
// Copies a drawn picture for the window; a sum that is not complete yet is filled up with the picture shown so far.
uniform sampler2D drawn;
uniform sampler2D shown;
uniform sampler2D frame_N;  // w != 0 where the last sample sees the cloth
uniform float gain;  // samples in all / samples finished
uniform int mode;    // 0 copy, 1 some samples are finished, 2 not even the first is
out vec4 color;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    color = texelFetch(drawn, pixel, 0);
    if (mode == 0) return;
    vec4 before = textureLod(shown, gl_FragCoord.xy / vec2(textureSize(drawn, 0)), 0.0);
    color *= gain;
    if (mode == 2) {
        // The objects have added something as well.
        bool covered = texelFetch(frame_N, pixel, 0).w != 0.0 || color.a > 0.0;
        color = covered ? vec4(color.rgb + max(1.0 - color.a, 0.0) * before.rgb, 1.0) : vec4(0.0);
    }
}
