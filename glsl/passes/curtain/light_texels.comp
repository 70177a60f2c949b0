#version 430
// The texels that shading reads: of charts the means of elements, of the curtain its receivers with some of the light that
// folds send each other.
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform samplerBuffer received;
uniform samplerBuffer sent;
uniform usamplerBuffer texel_sources;  // elements
uniform samplerBuffer texel_weights;
layout(std430) writeonly buffer Texels { vec4 texels[]; };
uniform int chart_texels;    // then come the curtain's
uniform int texel_count;
uniform int first_receiver;  // of the curtain
uniform int first_cell;      // of the curtain, among the senders
uniform float fold_share;

void main() {
    int i = item();
    if (i >= texel_count) return;
    if (i < chart_texels) {
        uvec4 from = texelFetch(texel_sources, i);
        vec4 w = texelFetch(texel_weights, i);
        texels[i] = w.x * texelFetch(received, int(from.x)) + w.y * texelFetch(received, int(from.y))
                    + w.z * texelFetch(received, int(from.z)) + w.w * texelFetch(received, int(from.w));
    } else {
        int k = i - chart_texels;
        texels[i] = texelFetch(received, first_receiver + k) + fold_share * texelFetch(sent, first_cell + k / 3);
    }
}
