/*
 * The parts of a renderer that the examples in C need: an instance, a device, a queue, command buffers, memory.
 */

#ifndef GEOSWEEP_EXAMPLES_HOST_H
#define GEOSWEEP_EXAMPLES_HOST_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "geosweep.h"

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
    uint32_t type = 0; /* Vulkan guarantees such a type */
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

/* Records a copy of an image of distances to a buffer, which the program reads. */
static void copy_to_host(const Host *host, const GeosweepImage *distances, const HostBuffer *to) {
    VkBufferImageCopy copy = {
        .imageSubresource = {.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT, .layerCount = 1},
        .imageExtent = {distances->extent.width, distances->extent.height, 1}};
    vkCmdCopyImageToBuffer(host->commands, distances->image, distances->layout, to->buffer, 1,
                           &copy);
    VkMemoryBarrier to_host = {VK_STRUCTURE_TYPE_MEMORY_BARRIER, NULL,
                               VK_ACCESS_TRANSFER_WRITE_BIT, VK_ACCESS_HOST_READ_BIT};
    vkCmdPipelineBarrier(host->commands, VK_PIPELINE_STAGE_TRANSFER_BIT,
                         VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &to_host, 0, NULL, 0, NULL);
}

/* Returns the larger of two numbers, or NaN if one of them is NaN. */
static double larger(double a, double b) {
    return a > b || isnan(a) ? a : b;
}

#endif
