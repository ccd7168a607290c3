// Computes prefix sums over the invocations of a workgroup.

// Limit of all sums, so that none wraps around.
const uint MOST = 1u << 30;

shared uint sums[WORKGROUP];

// Returns the sum of the values of this invocation and of those before it. Each value is at most MOST.
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
