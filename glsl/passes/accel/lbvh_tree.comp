#version 430
// The inner nodes of the tree that the sorted codes span, all at once.   [Karras 2012, figure 4]
// A node: (left child, right child, first key, last key); a child is a key's number | 0x80000000, or a node's number.
#include "trace/morton.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform usamplerBuffer keys;
layout(std430) writeonly buffer Tree { uvec4 tree_out[]; };
layout(std430) writeonly buffer Parents { uint parent[]; };  // of the nodes, then of the keys
uniform int key_count;

int prefix(int i, int j) {
    if (j < 0 || j >= key_count) return -1;
    return common_prefix(texelFetch(keys, i).x, texelFetch(keys, j).x, uint(i), uint(j));
}

void main() {
    int i = item();
    if (i >= key_count - 1) return;
    // The node's range of keys grows from i to the side where more bits agree.
    int direction = prefix(i, i + 1) > prefix(i, i - 1) ? 1 : -1;
    int least = prefix(i, i - direction);
    int reach = 2;
    while (prefix(i, i + reach * direction) > least) reach *= 2;
    int size = 0;
    for (int step = reach / 2; step > 0; step /= 2)
        if (prefix(i, i + (size + step) * direction) > least) size += step;
    int j = i + size * direction;
    // Its children part where the next bit changes.
    int shared_bits = prefix(i, j);
    int part = 0;
    int step = size;
    do {
        step = (step + 1) / 2;
        if (part + step < size && prefix(i, i + (part + step) * direction) > shared_bits) part += step;
    } while (step > 1);
    int split = i + part * direction + min(direction, 0);
    int first = min(i, j);
    int last = max(i, j);
    uint left = first == split ? uint(split) | 0x80000000u : uint(split);
    uint right = last == split + 1 ? uint(split + 1) | 0x80000000u : uint(split + 1);
    tree_out[i] = uvec4(left, right, first, last);
    parent[first == split ? key_count - 1 + split : split] = uint(i);
    parent[last == split + 1 ? key_count + split : split + 1] = uint(i);
    if (i == 0) parent[0] = 0xffffffffu;
}
