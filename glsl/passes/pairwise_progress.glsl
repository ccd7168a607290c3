// Declares the progress of each map of a batch.
// Twin: src/vulkan/pairwise/progress.rs.

struct Map {
    int source_col;     // column of its source
    int source_row;     // row of its source
    uint residual;      // largest change of a front in this iteration, in units of the last place
    uint next_residual; // takes the place of `residual` in odd iterations of maps in shared memory
    uint renews;        // 1 while curved fronts may be renewed
    uint iterations;    // number of iterations done, of four scans each
    uint last_residual; // residual of the last iteration done
    uint since_reached; // number of iterations since a point was last reached for the first time
    uint done;          // 1 once the map has converged or the iterations have run out
};

layout(set = 0, binding = 4) restrict buffer Progress {
    uint pending;       // number of maps that are not done
    uint tolerance;     // largest residual at which a map has converged
    uint most;          // largest number of iterations
    // Group counts of the indirect dispatches of further iterations, zero once all maps are done.
    uint row_groups[3]; // for a row of texels
    uint col_groups[3]; // for a column of texels
    Map maps[];
};

ivec2 source_of(uint map) {
    return ivec2(maps[map].source_col, maps[map].source_row);
}
