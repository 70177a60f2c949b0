#version 430
// Contact, step 2: where each bucket's vertices begin; one workgroup scans the whole table, each invocation a run of
// it. The counts are zeroed for the next time.
layout(local_size_x = 256) in;
layout(std430) buffer Count { int bucket_count[]; };
layout(std430) writeonly buffer Begin { int begin[]; };
layout(std430) writeonly buffer Cursor { int cursor[]; };
uniform int table_size;   // a multiple of 256
shared int total[256];

void main() {
    int lane = int(gl_LocalInvocationID.x);
    int run = table_size / 256;
    int sum = 0;
    for (int k = lane * run; k < (lane + 1) * run; k++) {
        sum += bucket_count[k];
    }
    total[lane] = sum;
    memoryBarrierShared();
    barrier();
    int before = 0;
    for (int k = 0; k < lane; k++) {
        before += total[k];
    }
    for (int k = lane * run; k < (lane + 1) * run; k++) {
        begin[k] = before;
        cursor[k] = before;
        before += bucket_count[k];
        bucket_count[k] = 0;
    }
}
