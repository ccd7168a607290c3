/* A renderer around the guide's frame, which tests/capi/programs.rs inserts. */

#define main example_main
#include "examples/embed.c"
#undef main

/* The snippet ignores the statuses of its calls, so they are checked here. */
#define geosweep_solver_create(...) check(geosweep_solver_create(__VA_ARGS__))
#define geosweep_surface_create(...) check(geosweep_surface_create(__VA_ARGS__))
#define geosweep_plan_create(...) check(geosweep_plan_create(__VA_ARGS__))
#define geosweep_record_prepare(...) check(geosweep_record_prepare(__VA_ARGS__))
#define geosweep_record_frame(...) check(geosweep_record_frame(__VA_ARGS__))

#define POINTS (256 * 256)

int main(int argc, char **argv) {
    Host host = open_host(argc > 1 ? argv[1] : "");
    VkInstance instance = host.instance;
    VkPhysicalDevice physical_device = host.physical_device;
    VkDevice device = host.device;
    /* Both may be the same command buffer: recordings of a surface wait for earlier ones. */
    VkCommandBuffer load_commands = host.commands, commands = host.commands;
    HostBuffer vertex_buffer = make_buffer(&host, 8 * POINTS), read = make_buffer(&host, POINTS);
    VkBuffer vertices = vertex_buffer.buffer;
    for (int i = 0; i < POINTS; i++) {
        float *vertex = vertex_buffer.mapped + 8 * i;
        vertex[0] = (float)SPACING * (float)(i % 256);
        vertex[1] = (float)SPACING * (float)(i / 256);
        vertex[2] = vertex[0];
    }
    GeosweepSolver *solver;
    GeosweepSurface *surface;
    GeosweepPlan *plan;
    GeosweepImage distances;
    begin(&host);

/* the guide's frame */

    /* Fragment shaders could read now. The test copies instead. */
    VkImageMemoryBarrier barrier = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
        .dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT,
        .oldLayout = distances.layout,
        .newLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
        .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .image = distances.image,
        .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1}};
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT,
                         VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 0, NULL, 0, NULL, 1, &barrier);
    VkBufferImageCopy copy = {
        .imageSubresource = {.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT, .layerCount = 1},
        .imageExtent = {distances.extent.width, distances.extent.height, 1}};
    vkCmdCopyImageToBuffer(commands, distances.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                           read.buffer, 1, &copy);
    submit_and_wait(&host);
    double error = 0.0;
    for (int i = 0; i < POINTS; i++) {
        error = larger(error_at(i / 256, i % 256, read.mapped[i], 1.0, source), error);
    }
    /* Distances on a plane are exact up to rounding: 3e-6 of the longest ones, which are about 140. */
    if (!(error < 4e-4)) {
        fprintf(stderr, "errors up to %g\n", error);
        return EXIT_FAILURE;
    }
    puts("the snippet's map is right");
    check(geosweep_surface_destroy(surface));
    check(geosweep_plan_destroy(plan));
    check(geosweep_solver_destroy(solver));
    free_buffer(&host, &vertex_buffer);
    free_buffer(&host, &read);
    close_host(&host);
    return EXIT_SUCCESS;
}
