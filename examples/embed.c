/*
 * geosweep in a C program that has a Vulkan device already: distances on a height field, recorded
 * into the program's own command buffer, and checked.
 *
 *     cargo rustc --release --lib --features capi --crate-type cdylib,staticlib
 *     cc -std=c99 -I src/capi examples/embed.c -L target/release -lgeosweep -lvulkan -lm -o embed
 *     LD_LIBRARY_PATH=target/release ./embed [PART OF A DEVICE'S NAME]
 */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "geosweep.h"

#define ROWS 120
#define COLS 160
#define SPACING 0.5 /* between rows and between columns */
#define PLACES 3
#define FRAMES 10

/* ---- A renderer has these: an instance, a device, a queue, command buffers, memory ---- */

typedef struct Host {
    VkInstance instance;
    VkPhysicalDevice physical_device;
    VkDevice device;
    VkQueue queue;
    VkCommandPool pool;
    VkCommandBuffer commands;
} Host;

typedef struct HostBuffer {
    VkBuffer buffer;
    VkDeviceMemory memory;
    float *mapped;
} HostBuffer;

static void check_vulkan(VkResult result, const char *call) {
    if (result != VK_SUCCESS) {
        fprintf(stderr, "%s: VkResult %d\n", call, (int)result);
        exit(EXIT_FAILURE);
    }
}

static void check(GeosweepStatus status) {
    if (status != GEOSWEEP_STATUS_SUCCESS) {
        fprintf(stderr, "geosweep, status %d: %s\n", (int)status, geosweep_last_error());
        exit(EXIT_FAILURE);
    }
}

/* Creates an instance, and a device on the first physical device that meets the requirements and has
   `wanted` in its name. */
static Host open_host(const char *wanted) {
    Host host = {0};
    GeosweepRequirements needed;
    check(geosweep_requirements(&needed));
    VkApplicationInfo application = {VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                     .apiVersion = needed.api_version};
    VkInstanceCreateInfo instance_info = {VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                          .pApplicationInfo = &application};
    check_vulkan(vkCreateInstance(&instance_info, NULL, &host.instance), "vkCreateInstance");

    VkPhysicalDevice devices[16];
    uint32_t count = 16;
    VkResult listed = vkEnumeratePhysicalDevices(host.instance, &count, devices);
    check_vulkan(listed == VK_INCOMPLETE ? VK_SUCCESS : listed, "vkEnumeratePhysicalDevices");
    for (uint32_t i = 0; i < count && !host.physical_device; i++) {
        VkPhysicalDeviceProperties properties;
        vkGetPhysicalDeviceProperties(devices[i], &properties);
        if (!strstr(properties.deviceName, wanted)) continue;
        if (geosweep_check_device(vkGetInstanceProcAddr, host.instance, devices[i]) ==
            GEOSWEEP_STATUS_SUCCESS) {
            host.physical_device = devices[i];
            printf("on %s\n", properties.deviceName);
        } else {
            fprintf(stderr, "not on %s: %s\n", properties.deviceName, geosweep_last_error());
        }
    }
    if (!host.physical_device) {
        fprintf(stderr, "no Vulkan device called \"%s\" meets the requirements\n", wanted);
        exit(EXIT_FAILURE);
    }

    uint32_t family;
    check(geosweep_compute_queue_family(vkGetInstanceProcAddr, host.instance, host.physical_device,
                                        &family));
    float priority = 1.0f;
    VkDeviceQueueCreateInfo queue_info = {VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                          .queueFamilyIndex = family,
                                          .queueCount = 1,
                                          .pQueuePriorities = &priority};
    VkDeviceCreateInfo device_info = {VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                      .queueCreateInfoCount = 1,
                                      .pQueueCreateInfos = &queue_info,
                                      .enabledExtensionCount = needed.device_extension_count,
                                      .ppEnabledExtensionNames = needed.device_extensions,
                                      .pEnabledFeatures = &needed.features};
    check_vulkan(vkCreateDevice(host.physical_device, &device_info, NULL, &host.device),
                 "vkCreateDevice");
    vkGetDeviceQueue(host.device, family, 0, &host.queue);

    VkCommandPoolCreateInfo pool_info = {VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, NULL,
                                         VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT, family};
    check_vulkan(vkCreateCommandPool(host.device, &pool_info, NULL, &host.pool), "the pool");
    VkCommandBufferAllocateInfo commands = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, NULL,
                                            host.pool, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1};
    check_vulkan(vkAllocateCommandBuffers(host.device, &commands, &host.commands), "the commands");
    return host;
}

static void close_host(Host *host) {
    vkDestroyCommandPool(host->device, host->pool, NULL);
    vkDestroyDevice(host->device, NULL);
    vkDestroyInstance(host->instance, NULL);
}

/* Creates a buffer for `floats` floats, which the program reads and writes. */
static HostBuffer make_buffer(const Host *host, uint32_t floats) {
    HostBuffer made;
    VkBufferCreateInfo info = {VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                               .size = floats * sizeof(float),
                               .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                                        VK_BUFFER_USAGE_TRANSFER_DST_BIT};
    check_vulkan(vkCreateBuffer(host->device, &info, NULL, &made.buffer), "vkCreateBuffer");
    VkMemoryRequirements needed;
    vkGetBufferMemoryRequirements(host->device, made.buffer, &needed);
    VkPhysicalDeviceMemoryProperties memory;
    vkGetPhysicalDeviceMemoryProperties(host->physical_device, &memory);
    const VkMemoryPropertyFlags wanted =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    uint32_t type = 0; /* Vulkan promises that there is one */
    while (!(needed.memoryTypeBits >> type & 1) ||
           (memory.memoryTypes[type].propertyFlags & wanted) != wanted) {
        type++;
    }
    VkMemoryAllocateInfo allocation = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, NULL, needed.size,
                                       type};
    check_vulkan(vkAllocateMemory(host->device, &allocation, NULL, &made.memory), "the memory");
    check_vulkan(vkBindBufferMemory(host->device, made.buffer, made.memory, 0), "binding it");
    void *mapped;
    check_vulkan(vkMapMemory(host->device, made.memory, 0, VK_WHOLE_SIZE, 0, &mapped), "mapping");
    made.mapped = mapped;
    return made;
}

static void free_buffer(const Host *host, HostBuffer *buffer) {
    vkDestroyBuffer(host->device, buffer->buffer, NULL);
    vkFreeMemory(host->device, buffer->memory, NULL);
}

static void begin(const Host *host) {
    VkCommandBufferBeginInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    check_vulkan(vkBeginCommandBuffer(host->commands, &info), "vkBeginCommandBuffer");
}

static void submit_and_wait(const Host *host) {
    check_vulkan(vkEndCommandBuffer(host->commands), "vkEndCommandBuffer");
    VkSubmitInfo info = {VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1,
                         .pCommandBuffers = &host->commands};
    check_vulkan(vkQueueSubmit(host->queue, 1, &info, VK_NULL_HANDLE), "vkQueueSubmit");
    check_vulkan(vkQueueWaitIdle(host->queue), "vkQueueWaitIdle");
}

/* Returns the error of a distance on a plane that rises along the rows. */
static double error_at(double row, double col, float distance, double slope,
                       GeosweepSource from) {
    double down = SPACING * (row - from.row), right = SPACING * (col - from.col);
    double exact = sqrt(down * down + right * right * (1.0 + slope * slope));
    return fabs(distance - exact);
}

static double larger(double a, double b) {
    return a > b || isnan(a) ? a : b;
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
            .before = none, /* what the program has written is there once it is submitted */
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
        VkBufferImageCopy copy = {
            .imageSubresource = {.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT, .layerCount = 1},
            .imageExtent = {distances.extent.width, distances.extent.height, 1}};
        vkCmdCopyImageToBuffer(host.commands, distances.image, distances.layout, read.buffer, 1,
                               &copy);
        VkMemoryBarrier to_host = {VK_STRUCTURE_TYPE_MEMORY_BARRIER, NULL,
                                   VK_ACCESS_TRANSFER_WRITE_BIT, VK_ACCESS_HOST_READ_BIT};
        vkCmdPipelineBarrier(host.commands, VK_PIPELINE_STAGE_TRANSFER_BIT,
                             VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &to_host, 0, NULL, 0, NULL);
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
