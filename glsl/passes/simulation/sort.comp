#version 430
// Contact, step 4: order each bucket by vertex number. The atomic counter filled it in any order; sums of floats in any
// order would differ in the last bit from run to run. One invocation per bucket.
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
layout(std430) readonly buffer Begin { int begin[]; };
layout(std430) readonly buffer Cursor { int cursor[]; };
layout(std430) buffer Member { int member[]; };
uniform int table_size;

void main() {
    int index = item();
    if (index >= table_size) {
        return;
    }
    int first = begin[index];
    int end = cursor[index];
    for (int k = first + 1; k < end; k++) {
        int value = member[k];
        int at = k;
        while (at > first && member[at - 1] > value) {
            member[at] = member[at - 1];
            at--;
        }
        member[at] = value;
    }
}
