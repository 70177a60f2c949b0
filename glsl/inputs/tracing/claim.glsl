// Places in lists that all work groups append to. Invocations claim theirs within the group, and the group claims all of
// them at once: one atomic operation a group and list, since cores that meet at one address wait for each other. Within the group
// an invocation claims its places in all lists at once, too: the group's counts are the bytes of one number, at most two places a
// list and invocation. Every invocation calls begin_claims(), claim() and settle_claims() once, outside of any branch.
// counts.glsl names the lists, below CLAIMS.
#include "inputs/tracing/counts.glsl"

shared uint claimed;
shared uint claimed_from[CLAIMS];

void begin_claims() {
    if (gl_LocalInvocationID.x == 0u) claimed = 0u;
    memoryBarrierShared();
    barrier();
}

// Claims so many places of each list; place_of() takes the result once the claims are settled.
uint claim(uvec4 wanted) {
    return atomicAdd(claimed, wanted.x | wanted.y << 8 | wanted.z << 16 | wanted.w << 24);
}

void settle_claims() {
    memoryBarrierShared();
    barrier();
    uint k = gl_LocalInvocationID.x;
    if (k < uint(CLAIMS)) {
        uint places = claimed >> (8u * k) & 255u;
        if (places != 0u) claimed_from[k] = atomicAdd(count[k], places);
    }
    memoryBarrierShared();
    barrier();
}

// The first of an invocation's places in list k.
uint place_of(int k, uint claim) { return claimed_from[k] + (claim >> uint(8 * k) & 255u); }
