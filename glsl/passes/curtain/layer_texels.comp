#version 430
// As passes/curtain/light_texels.comp, for the texels of two curtains, one behind the other. What lies between them is found first: E on
// the back of the front one and on the front of the one behind, each of what comes through one of them and what the other sends back,
// cell by cell. Then each curtain is as one alone, with light of its own on either side.
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform samplerBuffer received;
layout(std430) writeonly buffer Texels { vec4 texels[]; };
uniform int first_texel;     // of the curtains
uniform int texel_count;     // theirs
uniform int first_receiver;  // of the sheet that they are together,
uniform int cell_count;      // and its cells
uniform samplerBuffer sources;
uniform int first_source;    // what the front one sends of the lamp's light into the room and back, cell by cell; then the other
uniform vec3 shown[8];       // of each curtain, as there
uniform vec3 unshown[8];
uniform vec3 scattered[8];
uniform vec3 hidden[4];
uniform vec3 through[2];     // what the front one lets through into the gap, and the one behind
uniform vec3 back[2];        // what they send back into it

vec3 mean_of(int side, int cell) {
    int k = first_receiver + 3 * (side * cell_count + cell);
    return 0.25 * texelFetch(received, k).rgb + 0.5 * texelFetch(received, k + 1).rgb + 0.25 * texelFetch(received, k + 2).rgb;
}

vec3 flat_of(int side, int cell) { return texelFetch(received, first_receiver + 3 * (side * cell_count + cell) + 1).rgb; }

vec3 lamp_sent(int curtain, int side, int cell) {
    return texelFetch(sources, first_source + (2 * curtain + side) * cell_count + cell).rgb;
}

void main() {
    int i = item();
    if (i >= texel_count) return;
    int curtain = i / (6 * cell_count), of_curtain = i - curtain * 6 * cell_count;
    int side = of_curtain / (3 * cell_count), cell = of_curtain / 3 - side * cell_count;
    // Into the gap: from the room through the front one, from the window through the one behind; then to and fro.
    vec3 in_front = through[0] * flat_of(0, cell) + lamp_sent(0, 1, cell), in_back = through[1] * flat_of(1, cell) + lamp_sent(1, 0, cell);
    vec3 left = max(1.0 - back[0] * back[1], vec3(0.05));
    vec3 on_behind = (in_front + back[0] * in_back) / left, on_front = (in_back + back[1] * in_front) / left;
    vec3 E[2] = vec3[2](curtain == 0 ? flat_of(0, cell) : on_behind, curtain == 0 ? on_front : flat_of(1, cell));
    vec3 mean[2] = vec3[2](curtain == 0 ? mean_of(0, cell) : on_behind, curtain == 0 ? on_front : mean_of(1, cell));
    int c = 4 * curtain;
    vec3 front = scattered[c] * E[0] + scattered[c + 2] * E[1] + hidden[2 * curtain] * lamp_sent(curtain, 0, cell)
                 - shown[c] * mean[0] - shown[c + 1] * mean[1];
    vec3 rear = scattered[c + 1] * E[1] + scattered[c + 3] * E[0] + hidden[2 * curtain + 1] * lamp_sent(curtain, 1, cell)
                - shown[c + 2] * mean[0] - shown[c + 3] * mean[1];
    vec3 missing = unshown[c + 2 * side] * front + unshown[c + 2 * side + 1] * rear;
    bool outer = curtain == side;
    vec3 own = outer ? texelFetch(received, first_receiver + of_curtain).rgb : side == 0 ? on_behind : on_front;
    texels[first_texel + i] = vec4(max(own + missing, vec3(0.0)), 0.0);
}
