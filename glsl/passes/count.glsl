// Counts an iteration, given its largest change, and returns whether it was the last.
// Twin: crates/cpu/src/progress.rs.
bool count_iteration(uint change, uint tolerance, uint most, inout uint iterations,
                     inout uint since_reached, inout uint renews) {
    iterations += 1u;
    since_reached = change > FIRST_REACHED ? 0u : since_reached + 1u;
    if (since_reached >= PATIENCE) renews = 0u;
    return change <= tolerance || iterations >= most;
}
