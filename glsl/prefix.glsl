// Sums over the invocations of a workgroup.

// No sum is larger, so that none wraps around.
const uint MOST = 1u << 30;

shared uint sums[WORKGROUP];

// The sum of what this invocation and those before it give, each at most MOST.
uint sum_up_to_here(uint own) {
    uint here = gl_LocalInvocationID.x;
    uint sum = own;
    sums[here] = sum;
    for (uint reach = 1u; reach < WORKGROUP; reach *= 2u) {
        barrier();
        uint before = here >= reach ? sums[here - reach] : 0u;
        barrier();
        sum = min(sum + before, MOST);
        sums[here] = sum;
    }
    return sum;
}
