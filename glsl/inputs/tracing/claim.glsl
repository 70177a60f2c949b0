// Places in lists that all work groups append to. Invocations claim theirs within the group, and the group claims all of
// them at once: one atomic operation a group and list, since cores that meet at one address wait for each other. Every
// invocation calls begin_claims() and settle_claims() once, outside of any branch, and claims in between.
// counts.glsl names the lists, below CLAIMS.
#include "inputs/tracing/counts.glsl"

shared uint claimed[CLAIMS];
shared uint claimed_from[CLAIMS];

void begin_claims() {
    if (gl_LocalInvocationID.x < uint(CLAIMS)) claimed[gl_LocalInvocationID.x] = 0u;
    memoryBarrierShared();
    barrier();
}

// A place within the group's share of list k; counts from place_of(k, 0) once the claims are settled.
uint claim(int k) { return atomicAdd(claimed[k], 1u); }

void settle_claims() {
    memoryBarrierShared();
    barrier();
    uint k = gl_LocalInvocationID.x;
    if (k < uint(CLAIMS) && claimed[k] != 0u) claimed_from[k] = atomicAdd(count[k], claimed[k]);
    memoryBarrierShared();
    barrier();
}

uint place_of(int k, uint place) { return claimed_from[k] + place; }
