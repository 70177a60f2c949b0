#version 430
// Radix sort, second of three passes a digit: where the keys of each digit and chunk begin, by one work group.
layout(local_size_x = 64) in;
uniform usamplerBuffer histogram;
layout(std430) writeonly buffer Begins { uint begins[]; };
uniform int entry_count;
shared uint sums[64];

void main() {
    int t = int(gl_LocalInvocationID.x);
    int share = (entry_count + 63) / 64;
    int first = t * share;
    int end = min(first + share, entry_count);
    uint sum = 0u;
    for (int i = first; i < end; ++i) sum += texelFetch(histogram, i).x;
    sums[t] = sum;
    barrier();
    sum = 0u;
    for (int i = 0; i < t; ++i) sum += sums[i];
    for (int i = first; i < end; ++i) {
        begins[i] = sum;
        sum += texelFetch(histogram, i).x;
    }
}
