// A renderer with a frame graph in which geosweep computes the colors of a cloth. Each frame uploads the
// vertices, computes their distances from a source, and copies the distances back, where another renderer would
// draw with them.
//
// frame_graph [DEVICE [FOLDER]] writes the last frame's vertices and distances into a folder.

#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <fstream>
#include <string>
#include <vector>

#include "geosweep.hpp"
#include "graph.hpp"
#include "vulkan.hpp"

namespace {

constexpr uint32_t ROWS = 60, COLS = 72, POINTS = ROWS * COLS;
constexpr uint32_t FRAMES = 8, IN_FLIGHT = 2;

// Position and normal, as a vertex shader reads them.
struct Vertex {
    float position[3], normal[3];
};

constexpr size_t VERTEX_FLOATS = POINTS * sizeof(Vertex) / sizeof(float);

void move_cloth(Vertex *vertices, float time) {
    for (uint32_t i = 0; i < POINTS; i++) {
        float x = 0.1f * static_cast<float>(i % COLS), y = 0.1f * static_cast<float>(i / COLS);
        float z = 0.4f * std::sin(1.7f * x + time) * std::cos(1.1f * y);
        vertices[i] = {{x, y, z}, {0.0f, 0.0f, 1.0f}};
    }
}

// Resources that exist once for each frame in flight.
struct Frame {
    explicit Frame(const Gpu &gpu)
        : staging(gpu, VERTEX_FLOATS, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, true),
          vertices(gpu, VERTEX_FLOATS,
                   VK_BUFFER_USAGE_VERTEX_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                       VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                   false),
          distances(gpu, POINTS, VK_BUFFER_USAGE_TRANSFER_DST_BIT, true) {}

    Buffer staging, vertices, distances;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    VkFence fence = VK_NULL_HANDLE;
    bool was_submitted = false;
};

void write(const std::string &file, const float *floats, size_t count) {
    std::ofstream out(file, std::ios::binary);
    out.write(reinterpret_cast<const char *>(floats), static_cast<std::streamsize>(count * sizeof(float)));
    if (!out) throw std::runtime_error("cannot write " + file);
}

void render(const std::string &device, const std::string &folder) {
    GeosweepRequirements needs;
    geosweep::check(geosweep_requirements(&needs));
    Gpu gpu(device, needs.api_version, [](VkInstance instance, VkPhysicalDevice candidate) {
        GeosweepStatus status = geosweep_check_device(vkGetInstanceProcAddr, instance, candidate);
        return status == GEOSWEEP_STATUS_SUCCESS;
    });
    uint32_t family = 0;
    geosweep::check(geosweep_compute_queue_family(vkGetInstanceProcAddr, gpu.instance, gpu.physical_device, &family));
    gpu.open(family, needs.features);

    VkCommandPoolCreateInfo pool_info = {};
    pool_info.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
    pool_info.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
    pool_info.queueFamilyIndex = gpu.family;
    VkCommandPool pool;
    check(vkCreateCommandPool(gpu.device, &pool_info, nullptr, &pool), "vkCreateCommandPool");
    std::vector<Frame> frames;
    for (uint32_t i = 0; i < IN_FLIGHT; i++) {
        Frame &frame = frames.emplace_back(gpu);
        VkCommandBufferAllocateInfo commands = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, nullptr, pool,
                                                VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1};
        check(vkAllocateCommandBuffers(gpu.device, &commands, &frame.commands), "vkAllocateCommandBuffers");
        VkFenceCreateInfo fence = {VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, nullptr, 0};
        check(vkCreateFence(gpu.device, &fence, nullptr, &frame.fence), "vkCreateFence");
    }

    {
        // ---- Once: pipelines for the best schedule for the grid, a surface, a plan.
        GeosweepPasses passes = {GEOSWEEP_SCHEDULE_RASTER, GEOSWEEP_WAVEFRONT_CURVED};
        geosweep::check(geosweep_best_schedule(vkGetInstanceProcAddr, gpu.instance, gpu.physical_device, ROWS, COLS,
                                               &passes.schedule));
        GeosweepSolverInfo solver_info = geosweep::solver_info();
        solver_info.get_instance_proc_addr = vkGetInstanceProcAddr;
        solver_info.instance = gpu.instance;
        solver_info.physical_device = gpu.physical_device;
        solver_info.device = gpu.device;
        solver_info.passes = &passes;
        solver_info.pass_count = 1;
        solver_info.flags = GEOSWEEP_SOLVER_CHECKS;
        geosweep::Solver solver(solver_info);

        std::array<GeosweepPoints, IN_FLIGHT> points = {};
        for (uint32_t i = 0; i < IN_FLIGHT; i++) {
            points[i].buffer = frames[i].vertices.handle;
            points[i].stride = sizeof(Vertex);
        }
        GeosweepSurfaceInfo surface_info = {};
        surface_info.rows = ROWS;
        surface_info.cols = COLS;
        surface_info.slots = IN_FLIGHT;
        surface_info.points = points.data();
        surface_info.point_count = IN_FLIGHT;
        geosweep::Surface surface(solver, surface_info);

        GeosweepMethod method = {};
        method.wavefront = GEOSWEEP_WAVEFRONT_CURVED;
        method.tolerance = 1e-6;
        method.most_iterations = 100;
        method.iterations = 12;
        geosweep::Plan plan(solver, ROWS, COLS, method);

        // ---- Every frame: the graph's passes, one of which is geosweep's.
        for (uint32_t number = 0; number < FRAMES; number++) {
            uint32_t slot = number % IN_FLIGHT;
            Frame &frame = frames[slot];
            if (frame.was_submitted) {
                check(vkWaitForFences(gpu.device, 1, &frame.fence, VK_TRUE, UINT64_MAX), "vkWaitForFences");
                check(vkResetFences(gpu.device, 1, &frame.fence), "vkResetFences");
                GeosweepOutcome outcome;
                if (!surface.outcome(slot, outcome) || !outcome.converged || outcome.holes != 0 ||
                    outcome.passed_over != 0) {
                    throw std::runtime_error("a frame is not what it should be");
                }
            }
            move_cloth(reinterpret_cast<Vertex *>(frame.staging.mapped), 0.3f * static_cast<float>(number));
            GeosweepSource source = geosweep_source_at(12.0f + static_cast<float>(number), 20.5f);
            GeosweepImage distances = {};

            const Use copied = {VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT};
            const Use copied_from = {VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT};
            const Use computed_from = {VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_READ_BIT};
            const Use computed = {VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT};
            Graph graph;
            graph.add({"upload", {}, {{"vertices", copied}}, [&](VkCommandBuffer commands) {
                           VkBufferCopy copy = {0, 0, POINTS * sizeof(Vertex)};
                           vkCmdCopyBuffer(commands, frame.staging.handle, frame.vertices.handle, 1, &copy);
                       }});
            graph.add({"distances", {{"vertices", computed_from}}, {{"distances", computed}},
                       [&](VkCommandBuffer commands) {
                           if (number == 0) surface.prepare(commands);
                           Use before = graph.before("distances", "vertices");
                           GeosweepFrame info = {};
                           info.before = geosweep::access(before.stages, before.access);
                           info.points = slot;
                           info.slot = slot;
                           info.sources.sources = &source;
                           info.sources.count = 1;
                           info.plan = plan.get();
                           info.reader = {geosweep::access(copied_from.stages, copied_from.access),
                                          VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL};
                           info.unreached = -1.0f;
                           distances = surface.frame(commands, info);
                       },
                       true});
            graph.add({"read back", {{"distances", copied_from}}, {{"file", copied}}, [&](VkCommandBuffer commands) {
                           VkBufferImageCopy copy = {};
                           copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
                           copy.imageExtent = {distances.extent.width, distances.extent.height, 1};
                           vkCmdCopyImageToBuffer(commands, distances.image, distances.layout,
                                                  frame.distances.handle, 1, &copy);
                       }});
            graph.add({"file", {{"file", {VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT}}}, {},
                       [](VkCommandBuffer) {}});

            VkCommandBufferBeginInfo begin = {};
            begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
            check(vkBeginCommandBuffer(frame.commands, &begin), "vkBeginCommandBuffer");
            graph.record(frame.commands);
            check(vkEndCommandBuffer(frame.commands), "vkEndCommandBuffer");
            VkSubmitInfo submit = {};
            submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
            submit.commandBufferCount = 1;
            submit.pCommandBuffers = &frame.commands;
            check(vkQueueSubmit(gpu.queue, 1, &submit, frame.fence), "vkQueueSubmit");
            frame.was_submitted = true;
        }
        check(vkDeviceWaitIdle(gpu.device), "vkDeviceWaitIdle");
        const Frame &last = frames[(FRAMES - 1) % IN_FLIGHT];
        float farthest = 0.0f;
        for (uint32_t i = 0; i < POINTS; i++) farthest = std::fmax(farthest, last.distances.mapped[i]);
        std::printf("%u frames; in the last one the farthest point is %.4f away\n", FRAMES, farthest);
        if (!folder.empty()) {
            write(folder + "/vertices.bin", last.staging.mapped, VERTEX_FLOATS);
            write(folder + "/distances.bin", last.distances.mapped, POINTS);
        }
    }
    for (Frame &frame : frames) vkDestroyFence(gpu.device, frame.fence, nullptr);
    frames.clear();
    vkDestroyCommandPool(gpu.device, pool, nullptr);
}

}  // namespace

int main(int argc, char **argv) {
    try {
        render(argc > 1 ? argv[1] : "", argc > 2 ? argv[2] : "");
        return 0;
    } catch (const std::exception &error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
