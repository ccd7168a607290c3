/*
 * geosweep in a C program that has a Vulkan device already: distances on a height field, recorded
 * into the program's own command buffer, and checked.
 *
 *     cargo rustc --release -p geosweep-capi --crate-type cdylib,staticlib
 *     cc -std=c99 -I crates/capi/src examples/embed.c -L target/release -lgeosweep_capi -lvulkan -lm -o embed
 *     LD_LIBRARY_PATH=target/release ./embed [PART OF A DEVICE'S NAME]
 */

#include "host.h"

#define ROWS 120
#define COLS 160
#define SPACING 0.5 /* between rows and between columns */
#define PLACES 3
#define FRAMES 10

/* Returns the error of a distance on a plane that rises along the rows. */
static double error_at(double row, double col, float distance, double slope,
                       GeosweepSource from) {
    double down = SPACING * (row - from.row), right = SPACING * (col - from.col);
    double exact = sqrt(down * down + right * right * (1.0 + slope * slope));
    return fabs(distance - exact);
}

int main(int argc, char **argv) {
    Host host = open_host(argc > 1 ? argv[1] : "");

    /* A plane in the program's memory that tilts from frame to frame. A buffer or an image that shaders
       write can be used too. */
    static float heights[ROWS * COLS];
    HostBuffer places = make_buffer(&host, 2 * PLACES);
    HostBuffer found = make_buffer(&host, PLACES);
    HostBuffer read = make_buffer(&host, ROWS * COLS);
    const float wanted[2 * PLACES] = {0, 0, 0, COLS - 1, ROWS - 1, COLS - 1}; /* row, column */
    for (int i = 0; i < 2 * PLACES; i++) places.mapped[i] = wanted[i];

    /* ==== Once: pipelines, a surface, a plan of at most six iterations a frame ==== */
    GeosweepPasses passes = {GEOSWEEP_SCHEDULE_RASTER, GEOSWEEP_WAVEFRONT_CURVED};
    GeosweepSolverInfo solver_info = {.header_version = GEOSWEEP_HEADER_VERSION,
                                      .get_instance_proc_addr = vkGetInstanceProcAddr,
                                      .instance = host.instance,
                                      .physical_device = host.physical_device,
                                      .device = host.device,
                                      .passes = &passes,
                                      .pass_count = 1};
    GeosweepSolver *solver;
    check(geosweep_solver_create(&solver_info, &solver));

    GeosweepPoints points = {.kind = GEOSWEEP_POINT_KIND_HEIGHTS, .dx = SPACING, .dy = SPACING,
                             .data = heights, .stride = sizeof(float)};
    GeosweepLookup lookup = {.places = places.buffer, .distances = found.buffer, .count = PLACES};
    GeosweepSurfaceInfo surface_info = {.rows = ROWS, .cols = COLS,
                                        .slots = 1, /* as many as frames in flight */
                                        .points = &points, .point_count = 1,
                                        .lookups = &lookup, .lookup_count = 1};
    uint64_t bytes;
    check(geosweep_surface_bytes_for(solver, &surface_info, &bytes));
    printf("the surface will take %lu KiB\n", (unsigned long)(bytes / 1024));
    GeosweepSurface *surface;
    check(geosweep_surface_create(solver, &surface_info, &surface));

    GeosweepMethod method = {.wavefront = GEOSWEEP_WAVEFRONT_CURVED,
                             .tolerance = 1e-5,
                             .most_iterations = 100,
                             .iterations = 6};
    GeosweepPlan *plan;
    check(geosweep_plan_create(solver, ROWS, COLS, &method, &plan));

    begin(&host);
    check(geosweep_record_prepare(surface, host.commands));
    submit_and_wait(&host);

    for (int frame = 0; frame < FRAMES; frame++) {
        double slope = 0.25 * frame;
        for (int i = 0; i < ROWS * COLS; i++) heights[i] = (float)(slope * SPACING * (i % COLS));
        check(geosweep_surface_write_points(surface, 0, heights, NULL));

        /* ==== Every frame: where the fronts start, and who reads the result ==== */
        GeosweepSource source = geosweep_source_at(40.0f, 50.0f + (float)frame);
        const GeosweepAccess none = {0};
        const GeosweepAccess host_read = {VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT};
        GeosweepFrame info = {
            .before = none, /* what the program wrote before submitting is visible without a barrier */
            .sources = {.sources = &source, .count = 1},
            .plan = plan,
            .reader = {{VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT},
                       VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL},
            .unreached = INFINITY};
        GeosweepImage distances;
        begin(&host);
        check(geosweep_record_frame(surface, host.commands, &info, &distances));
        check(geosweep_record_lookup(surface, host.commands, 0, INFINITY, none, host_read));
        /* ---- The renderer samples distances.view, or as here copies distances.image ---- */
        copy_to_host(&host, &distances, &read);
        submit_and_wait(&host);

        GeosweepOutcome outcome;
        check(geosweep_surface_outcome(surface, 0, &outcome));
        double error = 0.0;
        for (int i = 0; i < ROWS * COLS; i++) {
            error = larger(error_at(i / COLS, i % COLS, read.mapped[i], slope, source), error);
        }
        for (int i = 0; i < PLACES; i++) {
            const float *place = &wanted[2 * i];
            error = larger(error_at(place[0], place[1], found.mapped[i], slope, source), error);
        }
        printf("frame %d: %.3f, %.3f and %.3f to three corners, %u iterations, errors up to %.1e\n",
               frame, found.mapped[0], found.mapped[1], found.mapped[2],
               (unsigned)outcome.iterations, error);
        /* Distances on a plane are exact up to rounding: 3e-6 of the longest ones, which are about 130. */
        if (!outcome.converged || !(error < 4e-4)) {
            fprintf(stderr, "this is not the distance on a plane\n");
            return EXIT_FAILURE;
        }
    }

    /* ==== At the end, once no frame is in flight ==== */
    check(geosweep_surface_destroy(surface));
    check(geosweep_plan_destroy(plan));
    check(geosweep_solver_destroy(solver));

    free_buffer(&host, &places);
    free_buffer(&host, &found);
    free_buffer(&host, &read);
    close_host(&host);
    return EXIT_SUCCESS;
}
