// How the maps of a batch go, each by itself. Twin: src/vulkan/pairwise/progress.rs.

struct Map {
    int source_col;     // its source's column
    int source_row;     // and row
    uint residual;      // largest change of a front in this iteration, in units of the last place;
    uint next_residual; // or, where a workgroup runs from one into the next, in every second one
    uint renews;        // 1 while curved fronts may be renewed
    uint iterations;    // of four scans, done so far
    uint last_residual; // that of the last iteration done
    uint since_reached; // iterations since a point was first reached
    uint done;          // 1 once the map has converged, or iterations have run out
};

layout(set = 0, binding = 4) restrict buffer Progress {
    uint pending;       // maps that are not done
    uint tolerance;     // residual at which a map has converged
    uint most;          // iterations, at most
    // What the dispatches of further iterations read, zero groups once all maps are done.
    uint row_groups[3]; // of a row of texels
    uint col_groups[3]; // of a column
    Map maps[];
};

ivec2 source_of(uint map) {
    return ivec2(maps[map].source_col, maps[map].source_row);
}
