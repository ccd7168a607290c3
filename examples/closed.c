/*
 * A closed tube in a C program: the last column of its grid is the first one again. Its cross-section is an
 * ellipse that swells and shrinks from frame to frame. Distances pass the seam, and those of each frame are
 * checked: unrolled, the tube is flat, and the shortest way goes round it on one side or the other.
 *
 *     cargo rustc --release -p geosweep-capi --crate-type cdylib,staticlib
 *     cc -std=c99 -I crates/capi/src examples/closed.c -L target/release -lgeosweep_capi -lvulkan -lm -o closed
 *     LD_LIBRARY_PATH=target/release ./closed [PART OF A DEVICE'S NAME]
 */

#include "host.h"

#define ROWS 61
#define COLS 129 /* the last column repeats the first one */
#define SPACING 0.05 /* between rows */
#define PIECES 64 /* of the arc from a column to the next, to measure its length */
#define FRAMES 10

typedef struct Tube {
    float points[ROWS * COLS][3];
    double along[COLS]; /* length of the cross-section from column 0 */
} Tube;

/* Moves the points. Columns 0 and COLS - 1 get the same points. */
static void move(Tube *tube, int frame) {
    const double step = 2.0 * acos(-1.0) / (COLS - 1);
    const double wide = 1.0 + 0.3 * sin(0.7 * frame), high = 1.0 - 0.3 * sin(0.7 * frame);
    tube->along[0] = 0.0;
    for (int col = 0; col < COLS; col++) {
        double angle = step * (col % (COLS - 1));
        for (int row = 0; row < ROWS; row++) {
            float *point = tube->points[row * COLS + col];
            point[0] = (float)(wide * cos(angle));
            point[1] = (float)(high * sin(angle));
            point[2] = (float)(SPACING * row);
        }
        double arc = 0.0;
        for (int piece = 0; piece < PIECES; piece++) {
            double middle = angle + step * (piece + 0.5) / PIECES;
            arc += hypot(wide * sin(middle), high * cos(middle)) * step / PIECES;
        }
        if (col + 1 < COLS) tube->along[col + 1] = tube->along[col] + arc;
    }
}

/* Returns the distance of a grid point from a source at a grid point. */
static double expected(const Tube *tube, int row, int col, GeosweepSource from) {
    double inside = fabs(tube->along[col] - tube->along[(int)from.col]);
    double over_seam = tube->along[COLS - 1] - inside;
    return hypot(SPACING * (row - from.row), fmin(inside, over_seam));
}

/* Returns the largest error of a map, relative to the distance. */
static double worst(const Tube *tube, const float *map, GeosweepSource from) {
    double error = 0.0;
    for (int i = 0; i < ROWS * COLS; i++) {
        double exact = expected(tube, i / COLS, i % COLS, from);
        error = larger(fabs(map[i] - exact) / fmax(exact, 1e-9), error);
    }
    return error;
}

static GeosweepSolver *make_solver(const Host *host) {
    GeosweepPasses passes = {GEOSWEEP_SCHEDULE_RASTER, GEOSWEEP_WAVEFRONT_CURVED};
    GeosweepSolverInfo info = {GEOSWEEP_HEADER_VERSION, vkGetInstanceProcAddr, host->instance,
                               host->physical_device, host->device, &passes, 1,
                               VK_NULL_HANDLE, 0, NULL};
    GeosweepSolver *solver;
    check(geosweep_solver_create(&info, &solver));
    return solver;
}

/* Records and runs a frame, and copies its distances. */
static void run_frame(const Host *host, GeosweepSurface *surface, const GeosweepPlan *plan,
                      GeosweepSource source, const HostBuffer *read) {
    GeosweepFrame frame = {
        .sources = {.sources = &source, .count = 1},
        .plan = plan,
        .reader = {{VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT},
                   VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL},
        .unreached = INFINITY};
    GeosweepImage distances;
    begin(host);
    check(geosweep_record_frame(surface, host->commands, &frame, &distances));
    copy_to_host(host, &distances, read);
    submit_and_wait(host);
}

/* Returns whether a frame has converged to the distances on the tube, with equal values on both sides of the seam. */
static int is_right(int frame, const Tube *tube, const GeosweepSurface *surface, const float *map,
                    GeosweepSource source) {
    GeosweepOutcome outcome;
    check(geosweep_surface_outcome(surface, 0, &outcome));
    int row = (int)source.row, left = COLS - 9, right = 8, differ = 0;
    for (int i = 0; i < ROWS; i++) {
        float first = map[i * COLS], last = map[i * COLS + COLS - 1];
        differ += !(fabsf(last - first) <= 1e-6f * first);
    }
    double error = worst(tube, map, source);
    printf("frame %d: from column %d, %.4f to column %d and %.4f to column %d, %u iterations, "
           "errors up to %.1e\n",
           frame, (int)source.col, map[row * COLS + left], left, map[row * COLS + right], right,
           (unsigned)outcome.iterations, error);
    /* Unrolled, the tube is flat. Distances on it are exact up to the rounding of the points, about 1e-6. */
    return outcome.converged && differ == 0 && error < 1e-5;
}

int main(int argc, char **argv) {
    Host host = open_host(argc > 1 ? argv[1] : "");
    static Tube tube;
    HostBuffer read = make_buffer(&host, ROWS * COLS);

    /* ==== Once: a surface whose columns are glued, and a plan over its seam ==== */
    GeosweepSolver *solver = make_solver(&host);
    move(&tube, 0);
    GeosweepPoints points = {.kind = GEOSWEEP_POINT_KIND_POSITIONS, .data = &tube.points[0][0],
                             .stride = sizeof tube.points[0]};
    GeosweepSurfaceInfo surface_info = {.rows = ROWS, .cols = COLS, .slots = 1,
                                        .points = &points, .point_count = 1,
                                        .gluing = GEOSWEEP_GLUING_COLUMNS};
    GeosweepSurface *surface;
    check(geosweep_surface_create(solver, &surface_info, &surface));
    GeosweepMethod method = {.wavefront = GEOSWEEP_WAVEFRONT_CURVED, .tolerance = 1e-6,
                             .most_iterations = 100, .iterations = 10, .over_seams = 1};
    GeosweepPlan *plan;
    check(geosweep_plan_create(solver, ROWS, COLS, &method, &plan));
    begin(&host);
    check(geosweep_record_prepare(surface, host.commands));
    submit_and_wait(&host);

    /* ==== Every frame: the tube moves, and the source walks over the seam ==== */
    for (int frame = 0; frame < FRAMES; frame++) {
        move(&tube, frame);
        check(geosweep_surface_write_points(surface, 0, &tube.points[0][0], NULL));
        GeosweepSource source = geosweep_source_at(20.0f, (float)((COLS - 6 + frame) % (COLS - 1)));
        run_frame(&host, surface, plan, source, &read);
        if (!is_right(frame, &tube, surface, read.mapped, source)) {
            fprintf(stderr, "these are not the distances on a closed tube\n");
            return EXIT_FAILURE;
        }
    }

    check(geosweep_surface_destroy(surface));
    check(geosweep_plan_destroy(plan));
    check(geosweep_solver_destroy(solver));
    free_buffer(&host, &read);
    close_host(&host);
    return EXIT_SUCCESS;
}
