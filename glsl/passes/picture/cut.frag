#version 430
// Uncovers the pixels of a surface that another one, drawn later, hides: no frame, and the far plane's depth.
uniform sampler2D later_N;  // frame_N of the one that hides it
layout(location = 0) out vec4 frame_N;
layout(location = 1) out vec4 frame_x;
layout(location = 2) out vec4 frame_p;
layout(location = 3) out vec2 frame_b;

void main() {
    if (texelFetch(later_N, ivec2(gl_FragCoord.xy), 0).w == 0.0) discard;
    frame_N = frame_x = frame_p = vec4(0.0);
    frame_b = vec2(0.0);
    gl_FragDepth = 1.0;
}
