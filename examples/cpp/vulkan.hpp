// A minimal renderer: an instance, a device with a queue, and buffers.
#pragma once

#include <cstring>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <vulkan/vulkan.h>

inline void check(VkResult result, const char *call) {
    if (result != VK_SUCCESS) throw std::runtime_error(std::string(call) + " failed: " + std::to_string(result));
}

class Gpu {
public:
    // Takes the first device whose name contains `part` and which `is_usable` accepts.
    template <class Test>
    Gpu(const std::string &part, uint32_t api_version, Test is_usable) {
        VkApplicationInfo application = {};
        application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
        application.apiVersion = api_version;
        VkInstanceCreateInfo info = {};
        info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
        info.pApplicationInfo = &application;
        check(vkCreateInstance(&info, nullptr, &instance), "vkCreateInstance");
        uint32_t count = 0;
        check(vkEnumeratePhysicalDevices(instance, &count, nullptr), "vkEnumeratePhysicalDevices");
        std::vector<VkPhysicalDevice> devices(count);
        check(vkEnumeratePhysicalDevices(instance, &count, devices.data()), "vkEnumeratePhysicalDevices");
        for (VkPhysicalDevice candidate : devices) {
            VkPhysicalDeviceProperties properties;
            vkGetPhysicalDeviceProperties(candidate, &properties);
            bool is_named = std::strstr(properties.deviceName, part.c_str()) != nullptr;
            if (is_named && is_usable(instance, candidate)) {
                physical_device = candidate;
                break;
            }
        }
        if (physical_device == VK_NULL_HANDLE) throw std::runtime_error("no device will do");
    }

    Gpu(const Gpu &) = delete;

    void open(uint32_t of_family, const VkPhysicalDeviceFeatures &features) {
        family = of_family;
        const float priority = 1.0f;
        VkDeviceQueueCreateInfo queues = {};
        queues.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
        queues.queueFamilyIndex = family;
        queues.queueCount = 1;
        queues.pQueuePriorities = &priority;
        VkDeviceCreateInfo info = {};
        info.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
        info.queueCreateInfoCount = 1;
        info.pQueueCreateInfos = &queues;
        info.pEnabledFeatures = &features;
        check(vkCreateDevice(physical_device, &info, nullptr, &device), "vkCreateDevice");
        vkGetDeviceQueue(device, family, 0, &queue);
    }

    ~Gpu() {
        if (device != VK_NULL_HANDLE) vkDestroyDevice(device, nullptr);
        if (instance != VK_NULL_HANDLE) vkDestroyInstance(instance, nullptr);
    }

    uint32_t memory_type(uint32_t allowed, VkMemoryPropertyFlags wanted) const {
        VkPhysicalDeviceMemoryProperties memory;
        vkGetPhysicalDeviceMemoryProperties(physical_device, &memory);
        for (uint32_t type = 0; type < memory.memoryTypeCount; type++) {
            bool has_all = (memory.memoryTypes[type].propertyFlags & wanted) == wanted;
            if ((allowed >> type & 1) && has_all) return type;
        }
        throw std::runtime_error("no such memory");
    }

    VkInstance instance = VK_NULL_HANDLE;
    VkPhysicalDevice physical_device = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    VkQueue queue = VK_NULL_HANDLE;
    uint32_t family = 0;
};

// A buffer of floats, mapped if the program writes or reads it.
class Buffer {
public:
    Buffer(const Gpu &gpu, size_t floats, VkBufferUsageFlags usage, bool is_mapped)
        : floats(floats), device_(gpu.device) {
        VkBufferCreateInfo info = {};
        info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
        info.size = floats * sizeof(float);
        info.usage = usage;
        check(vkCreateBuffer(device_, &info, nullptr, &handle), "vkCreateBuffer");
        VkMemoryRequirements needed;
        vkGetBufferMemoryRequirements(device_, handle, &needed);
        VkMemoryAllocateInfo allocation = {};
        allocation.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
        allocation.allocationSize = needed.size;
        allocation.memoryTypeIndex = gpu.memory_type(
            needed.memoryTypeBits, is_mapped ? VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT
                                             : VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
        check(vkAllocateMemory(device_, &allocation, nullptr, &memory_), "vkAllocateMemory");
        check(vkBindBufferMemory(device_, handle, memory_, 0), "vkBindBufferMemory");
        if (!is_mapped) return;
        void *there;
        check(vkMapMemory(device_, memory_, 0, VK_WHOLE_SIZE, 0, &there), "vkMapMemory");
        mapped = static_cast<float *>(there);
    }

    Buffer(const Buffer &) = delete;
    Buffer(Buffer &&other) noexcept
        : handle(std::exchange(other.handle, VK_NULL_HANDLE)), mapped(other.mapped), floats(other.floats),
          device_(other.device_), memory_(std::exchange(other.memory_, VK_NULL_HANDLE)) {}

    ~Buffer() {
        vkDestroyBuffer(device_, handle, nullptr);
        vkFreeMemory(device_, memory_, nullptr);
    }

    VkBuffer handle = VK_NULL_HANDLE;
    float *mapped = nullptr;
    size_t floats;

private:
    VkDevice device_;
    VkDeviceMemory memory_ = VK_NULL_HANDLE;
};
