#version 430
// The texels that shading reads: of charts the means of elements, of the curtain its receivers with the light that folds send
// each other. What the curtain shows of its light as a whole, from the room and from behind, is known from paths among its
// folds: B' = scattered E + what the lamp's light does by way of layers that are not seen. Shading shows C X of an irradiance
// X on the layers, so X = E + C^-1 (B' - C E), E here the mean over the folds' normals.
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform samplerBuffer received;
uniform usamplerBuffer texel_sources;  // elements
uniform samplerBuffer texel_weights;
layout(std430) writeonly buffer Texels { vec4 texels[]; };
uniform int chart_texels;    // then come the curtain's
uniform int texel_count;
uniform int first_receiver;  // of the curtain
uniform int first_cell;      // of the curtain, among the senders
uniform int cell_count;      // of a side
uniform samplerBuffer sources;  // what senders send of the lamp and the sky,
uniform samplerBuffer sky;      // and of the sky alone
uniform vec3 shown[4];       // C: of the front and the back of the cloth, seen from the room; from behind
uniform vec3 unshown[4];     // its inverse
uniform vec3 scattered[4];   // reflected, from the room and from behind; transmitted
uniform vec3 hidden[2];      // of what a side sends of the lamp

vec3 mean_of(int side, int cell) {
    int k = first_receiver + 3 * (side * cell_count + cell);
    return 0.25 * texelFetch(received, k).rgb + 0.5 * texelFetch(received, k + 1).rgb + 0.25 * texelFetch(received, k + 2).rgb;
}

vec3 flat_of(int side, int cell) { return texelFetch(received, first_receiver + 3 * (side * cell_count + cell) + 1).rgb; }

vec3 lamp_hidden(int side, int cell) {
    int k = first_cell + side * cell_count + cell;
    return hidden[side] * (texelFetch(sources, k).rgb - texelFetch(sky, k).rgb);
}

// What is missing on a side.
vec3 from_folds(int side, int cell) {
    vec3 E[2] = vec3[2](flat_of(0, cell), flat_of(1, cell));
    vec3 mean[2] = vec3[2](mean_of(0, cell), mean_of(1, cell));
    vec3 front = scattered[0] * E[0] + scattered[2] * E[1] + lamp_hidden(0, cell) - shown[0] * mean[0] - shown[1] * mean[1];
    vec3 back = scattered[1] * E[1] + scattered[3] * E[0] + lamp_hidden(1, cell) - shown[2] * mean[0] - shown[3] * mean[1];
    return unshown[2 * side] * front + unshown[2 * side + 1] * back;
}

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
        int side = k / (3 * cell_count);
        vec3 E = texelFetch(received, first_receiver + k).rgb + from_folds(side, k / 3 - side * cell_count);
        texels[i] = vec4(max(E, vec3(0.0)), 0.0);
    }
}
