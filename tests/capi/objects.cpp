/* Assigns and moves objects of geosweep.hpp, and converts 64-bit accesses. Fails if any result is wrong. */
#include <cstring>

static unsigned refusals = 0;
#define GEOSWEEP_NOT_DESTROYED(why) (refusals++, std::fprintf(stderr, "not destroyed: %s\n", why))

#include "geosweep.hpp"
#include "vulkan.hpp"

static void require(bool holds, const char *what) {
    if (!holds) throw std::runtime_error(what);
}

/* Device memory that the program holds, counted by its own allocator. */
struct Held {
    VkDevice device;
    uint32_t device_type, host_type;
    int blocks;
};

static VkResult allocate(void *user, const GeosweepMemoryRequest *request, GeosweepMemory *memory) {
    Held *held = static_cast<Held *>(user);
    const bool is_mapped = (request->required & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT) != 0;
    VkMemoryAllocateInfo info = VkMemoryAllocateInfo();
    info.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
    info.allocationSize = request->requirements.size;
    info.memoryTypeIndex = is_mapped ? held->host_type : held->device_type;
    VkResult result = vkAllocateMemory(held->device, &info, nullptr, &memory->memory);
    if (result == VK_SUCCESS && is_mapped) {
        result = vkMapMemory(held->device, memory->memory, 0, VK_WHOLE_SIZE, 0, &memory->mapped);
    }
    held->blocks += result == VK_SUCCESS;
    return result;
}

static void take_back(void *user, const GeosweepMemory *memory) {
    Held *held = static_cast<Held *>(user);
    vkFreeMemory(held->device, memory->memory, nullptr);
    held->blocks--;
}

static geosweep::Solver solver_on(const Gpu &gpu, const GeosweepAllocator &allocator) {
    GeosweepPasses passes = {GEOSWEEP_SCHEDULE_RASTER, GEOSWEEP_WAVEFRONT_CURVED};
    GeosweepSolverInfo info = geosweep::solver_info();
    info.get_instance_proc_addr = vkGetInstanceProcAddr;
    info.instance = gpu.instance;
    info.physical_device = gpu.physical_device;
    info.device = gpu.device;
    info.passes = &passes;
    info.pass_count = 1;
    info.flags = GEOSWEEP_SOLVER_CHECKS;
    info.allocator = &allocator;
    return geosweep::Solver(info);
}

static void objects_are_assigned(const Gpu &gpu) {
    const VkMemoryPropertyFlags mapped = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    Held first = {gpu.device, gpu.memory_type(~0u, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT), gpu.memory_type(~0u, mapped), 0};
    Held second = first;
    GeosweepAllocator of_first = {&first, allocate, take_back}, of_second = {&second, allocate, take_back};
    GeosweepSolver *gone = nullptr;
    {
        geosweep::SurfaceInfo info(9, 12);
        geosweep::Solver one = solver_on(gpu, of_first);
        gone = one.get();
        geosweep::Surface surface(one, info);
        geosweep::Plan plan(one, 9, 12, geosweep::Method(GEOSWEEP_WAVEFRONT_CURVED));
        require(first.blocks > 0 && plan.iterations() == 8, "a surface and a plan are made");
        /* Afterwards only `surface` and `plan` own the first solver. */
        one = solver_on(gpu, of_second);
        surface = geosweep::Surface(one, info);
        require(first.blocks == 0 && second.blocks > 0, "the surface before was destroyed");
        plan = geosweep::Plan(one, 9, 12, geosweep::Method(GEOSWEEP_WAVEFRONT_CURVED).in_a_recording(4));
        require(plan.iterations() == 4, "the plan is the new one");
        require(refusals == 0, "nothing was refused");
        /* With checks, the object's memory is kept and shows that the object was destroyed. */
        uint64_t bytes = 0;
        require(geosweep_solver_bytes(gone, &bytes) != GEOSWEEP_STATUS_SUCCESS &&
                    std::strstr(geosweep_last_error(), "was destroyed before") != nullptr,
                "the solver before was destroyed");
        geosweep::Surface moved(std::move(surface));
        require(moved.get() != nullptr && surface.get() == nullptr, "a surface moves");
    }
    require(first.blocks == 0 && second.blocks == 0 && refusals == 0, "everything was destroyed");
}

static void accesses_of_64_bits_are_mapped() {
    const uint64_t copy = uint64_t(1) << 32, stored = uint64_t(1) << 34;
    GeosweepAccess mapped = geosweep::access(copy, uint64_t(VK_ACCESS_TRANSFER_WRITE_BIT));
    require(mapped.stages == VK_PIPELINE_STAGE_TRANSFER_BIT && mapped.access == VK_ACCESS_TRANSFER_WRITE_BIT, "a copy");
    mapped = geosweep::access(uint64_t(VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT), stored);
    require(mapped.stages == VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT && mapped.access == VK_ACCESS_SHADER_WRITE_BIT,
            "a storage write");
    mapped = geosweep::access(VK_PIPELINE_STAGE_VERTEX_SHADER_BIT, VK_ACCESS_SHADER_READ_BIT);
    require(mapped.stages == VK_PIPELINE_STAGE_VERTEX_SHADER_BIT && mapped.access == VK_ACCESS_SHADER_READ_BIT, "32 bits");
    mapped = geosweep::access(0, 0);
    require(mapped.stages == 0 && mapped.access == 0, "none");
    for (int bit = 39; bit < 64; bit++) {
        bool refused = false;
        try {
            geosweep::access(uint64_t(1) << bit, VK_ACCESS_SHADER_READ_BIT);
        } catch (const std::invalid_argument &) {
            refused = true;
        }
        require(refused, "a stage without a name is refused");
    }
}

int main(int argc, char **argv) {
    try {
        accesses_of_64_bits_are_mapped();
        Gpu gpu(argc > 1 ? argv[1] : "", VK_API_VERSION_1_1, [](VkInstance instance, VkPhysicalDevice candidate) {
            return geosweep_check_device(vkGetInstanceProcAddr, instance, candidate) == GEOSWEEP_STATUS_SUCCESS;
        });
        uint32_t family = 0;
        geosweep::check(
            geosweep_compute_queue_family(vkGetInstanceProcAddr, gpu.instance, gpu.physical_device, &family));
        gpu.open(family, VkPhysicalDeviceFeatures());
        objects_are_assigned(gpu);
        std::printf("objects and accesses are as they should\n");
        return 0;
    } catch (const std::exception &error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
