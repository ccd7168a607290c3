/* Contours and paths in C, on a saddle with a hole. The program checks what must hold on any surface, and
   prints the rest for tests/capi/curves.rs to compare. */

#define main example_main
#include "examples/embed.c"
#undef main

#define LEVELS 7
#define STEP 11.5f
#define ROOM 6000
#define PATHS 4
#define PATH_ROOM 400

/* The saddle of tests/capi/curves.rs. The hole contains values that are not heights. */
static void fill(float *heights, uint8_t *mask) {
    for (int row = 0; row < ROWS; row++) {
        for (int col = 0; col < COLS; col++) {
            int hole = row >= 70 && row < 75 && col >= 60 && col < 90;
            mask[row * COLS + col] = (uint8_t)!hole;
            heights[row * COLS + col] = hole ? 1e6f : (float)((row - 60) * (col - 80)) / 256.0f;
        }
    }
}

static GeosweepCurveRecord record_of(const HostBuffer *read, uint32_t number) {
    const uint8_t *bytes = (const uint8_t *)read->mapped + number * GEOSWEEP_CURVE_RECORD_BYTES;
    GeosweepCurveRecord record;
    check(geosweep_curve_record_from_bytes(bytes, &record));
    VkDrawIndirectCommand draw;
    memcpy(&draw, bytes, sizeof draw);
    if (draw.vertexCount != record.vertex_count || draw.instanceCount != 1 ||
        draw.firstVertex != record.first_vertex || draw.firstInstance != 0) {
        fprintf(stderr, "the draw of curve %u is not that of its record\n", (unsigned)number);
        exit(EXIT_FAILURE);
    }
    return record;
}

static void print(const char *name, const GeosweepCurves *curves, const HostBuffer *read) {
    const uint8_t *bytes = (const uint8_t *)read->mapped + curves->vertices_offset;
    for (uint32_t number = 0; number < curves->curves; number++) {
        GeosweepCurveRecord record = record_of(read, number);
        printf("%s %d %u %u %u %u %.9g %.9g\n", name, (int)record.status,
               (unsigned)record.vertex_count, (unsigned)record.first_vertex,
               (unsigned)record.vertices, (unsigned)record.source, record.distance, record.length);
        for (uint32_t k = 0; k < record.vertex_count; k++) {
            GeosweepCurveVertex at;
            memcpy(&at, bytes + (record.first_vertex + k) * sizeof at, sizeof at);
            printf("vertex %.9g %.9g %.9g %.9g %.9g %.9g\n", at.position[0], at.position[1],
                   at.position[2], at.time, at.row, at.col);
        }
    }
}

static uint32_t floats_of(const GeosweepCurves *curves) {
    uint64_t bytes = (uint64_t)curves->curves * curves->capacity * sizeof(GeosweepCurveVertex);
    return (uint32_t)((curves->vertices_offset + bytes) / sizeof(float));
}

static void same(uint64_t stated, uint64_t taken) {
    if (stated != taken || stated == 0) {
        fprintf(stderr, "%lu bytes, and %lu were stated\n", (unsigned long)taken,
                (unsigned long)stated);
        exit(EXIT_FAILURE);
    }
}

int main(int argc, char **argv) {
    Host host = open_host(argc > 1 ? argv[1] : "");
    static float heights[ROWS * COLS];
    static uint8_t mask[ROWS * COLS];
    fill(heights, mask);

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
                             .data = heights, .mask = mask, .stride = sizeof(float)};
    GeosweepSurfaceInfo surface_info = {.rows = ROWS, .cols = COLS, .slots = 1,
                                        .points = &points, .point_count = 1};
    GeosweepSurface *surface;
    check(geosweep_surface_create(solver, &surface_info, &surface));
    GeosweepMethod method = {.wavefront = GEOSWEEP_WAVEFRONT_CURVED, .tolerance = 1e-6,
                             .most_iterations = 100, .iterations = 12};
    GeosweepPlan *plan;
    check(geosweep_plan_create(solver, ROWS, COLS, &method, &plan));

    /* ==== Once per surface ==== */
    GeosweepContours *contours;
    GeosweepPaths *paths;
    check(geosweep_contours_create(surface, ROOM, &contours));
    check(geosweep_paths_create(surface, PATHS, PATH_ROOM, &paths));
    uint64_t stated, taken;
    check(geosweep_contours_bytes_for(solver, ROWS, COLS, ROOM, &stated));
    check(geosweep_contours_bytes(contours, &taken));
    same(stated, taken);
    check(geosweep_paths_bytes_for(solver, PATHS, PATH_ROOM, &stated));
    check(geosweep_paths_bytes(paths, &taken));
    same(stated, taken);

    GeosweepCurves lines, strips;
    check(geosweep_contours_curves(contours, &lines));
    check(geosweep_paths_curves(paths, &strips));
    HostBuffer read_lines = make_buffer(&host, floats_of(&lines));
    HostBuffer read_strips = make_buffer(&host, floats_of(&strips));

    /* ==== Every frame, after the map; a renderer reads the curves where it draws them ==== */
    const GeosweepAccess read = {VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT};
    GeosweepSource source = geosweep_source_at(100.0f, 70.5f);
    GeosweepSources sources = {.sources = &source, .count = 1};
    GeosweepFrame frame = {.sources = sources, .plan = plan,
                           .reader = {read, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL},
                           .unreached = INFINITY};
    GeosweepContourFrame contour_frame = {.level_count = LEVELS, .step = STEP, .reader = read};
    /* Starts behind the hole, at a corner of the grid and off the grid. The fourth path has no start. */
    const float starts[] = {20.25f, 81.5f, 0.0f, 159.0f, -3.0f, 5.0f};
    GeosweepPathFrame path_frame = {.starts = starts, .start_count = 3, .sources = sources,
                                    .reader = read};
    begin(&host);
    check(geosweep_record_prepare(surface, host.commands));
    check(geosweep_record_frame(surface, host.commands, &frame, NULL));
    check(geosweep_record_contours(surface, host.commands, contours, &contour_frame, &lines));
    check(geosweep_record_paths(surface, host.commands, paths, &path_frame, &strips));
    VkBufferCopy copy_lines = {.size = floats_of(&lines) * sizeof(float)};
    VkBufferCopy copy_strips = {.size = floats_of(&strips) * sizeof(float)};
    vkCmdCopyBuffer(host.commands, lines.buffer, read_lines.buffer, 1, &copy_lines);
    vkCmdCopyBuffer(host.commands, strips.buffer, read_strips.buffer, 1, &copy_strips);
    VkMemoryBarrier to_host = {VK_STRUCTURE_TYPE_MEMORY_BARRIER, NULL,
                               VK_ACCESS_TRANSFER_WRITE_BIT, VK_ACCESS_HOST_READ_BIT};
    vkCmdPipelineBarrier(host.commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT,
                         0, 1, &to_host, 0, NULL, 0, NULL);
    submit_and_wait(&host);
    print("contours", &lines, &read_lines);
    print("path", &strips, &read_strips);

    /* ==== Before or after the surface, but before the solver ==== */
    check(geosweep_contours_destroy(contours));
    check(geosweep_surface_destroy(surface));
    check(geosweep_plan_destroy(plan));
    if (geosweep_solver_destroy(solver) != GEOSWEEP_STATUS_INVALID_ARGUMENT) {
        fprintf(stderr, "the solver went before its paths\n");
        return EXIT_FAILURE;
    }
    check(geosweep_paths_destroy(paths));
    check(geosweep_solver_destroy(solver));
    free_buffer(&host, &read_lines);
    free_buffer(&host, &read_strips);
    close_host(&host);
    return EXIT_SUCCESS;
}
