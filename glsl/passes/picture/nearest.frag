#version 430
// The depth of one surface, for the nearest of several.
uniform sampler2D depth;

void main() {
    gl_FragDepth = texelFetch(depth, ivec2(gl_FragCoord.xy), 0).r;
}
