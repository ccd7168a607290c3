/*
 * A Vulkan layer that changes the properties that a device reports, and replaces shaders. It lets tests run on
 * devices that the machine does not have.
 *
 *     GUISE_TYPE=discrete        or integrated, virtual, cpu: the kind of device
 *     GUISE_MEMORY=own           memory of its own, beside the host's: three types of memory in two heaps
 *     GUISE_LIMITS=minimum       the limits that Vulkan 1.1 requires of every device. Limits by name may follow,
 *                                or stand alone: storage_images=3,image_side=1024 (the table LIMITS has the names)
 *     GUISE_VERSION=1.0          the version of Vulkan
 *     GUISE_WITHOUT_FORMAT=100   a VkFormat of which the device has no images
 *     GUISE_POISON=0x7fc00000    a word that fills all new memory that the host can map
 *     GUISE_MODULES=FOLDER       modules that replace others: files named by the FNV-1a of the replaced module,
 *                                as arithmetic.py writes them
 *     GUISE_FOLD=FOLDER          spirv-opt folds specialization constants into each module before the driver
 *                                receives it; the folder keeps the results
 *
 * Build: cc -shared -fPIC -O1 -o libguise.so guise.c -lpthread. The loader finds it by guise.json.
 */
#include <pthread.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

/* ------------------------------------------------------------------ the next functions in the chain */

typedef struct Instance {
    void *key; /* of the instance and of its physical devices; see key_of */
    VkInstance handle;
    PFN_vkGetInstanceProcAddr get;
    PFN_vkDestroyInstance destroy;
    PFN_vkGetPhysicalDeviceProperties properties;
    PFN_vkGetPhysicalDeviceProperties2 properties2;
    PFN_vkGetPhysicalDeviceImageFormatProperties image_format;
    PFN_vkGetPhysicalDeviceFeatures features;
    PFN_vkGetPhysicalDeviceMemoryProperties memory;
    PFN_vkGetPhysicalDeviceMemoryProperties2 memory2;
    struct Instance *next;
} Instance;

typedef struct Device {
    void *key;
    VkDevice handle;
    PFN_vkGetDeviceProcAddr get;
    PFN_vkDestroyDevice destroy;
    PFN_vkCreateShaderModule create_module;
    PFN_vkDestroyShaderModule destroy_module;
    PFN_vkCreateComputePipelines create_pipelines;
    PFN_vkAllocateMemory allocate;
    PFN_vkGetBufferMemoryRequirements of_buffer;
    PFN_vkGetBufferMemoryRequirements2 of_buffer2;
    PFN_vkGetImageMemoryRequirements of_image;
    PFN_vkGetImageMemoryRequirements2 of_image2;
    PFN_vkMapMemory map;
    PFN_vkUnmapMemory unmap;
    struct Device *next;
} Device;

typedef struct Module {
    VkShaderModule handle;
    uint32_t *code;
    size_t size;
    struct Module *next;
} Module;

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static Instance *instances;
static Device *devices;
static Module *modules; /* only where constants are folded */

/* Returns the loader's table of functions, which identifies the owner of a handle. */
static void *key_of(const void *handle) { return *(void *const *)handle; }

static Instance *instance_of(const void *handle) {
    pthread_mutex_lock(&lock);
    Instance *found = instances;
    while (found && found->key != key_of(handle)) found = found->next;
    pthread_mutex_unlock(&lock);
    return found;
}

static Device *device_of(const void *handle) {
    pthread_mutex_lock(&lock);
    Device *found = devices;
    while (found && found->key != key_of(handle)) found = found->next;
    pthread_mutex_unlock(&lock);
    return found;
}

static const char *wish(const char *name) {
    const char *value = getenv(name);
    return value && *value ? value : NULL;
}

/* ------------------------------------------------------------------ properties that a device reports */

/* Limits that Vulkan 1.1 requires, as far as they can matter to this crate or its dependencies. */
static const struct {
    const char *name;
    size_t offset;
    uint32_t required;
} LIMITS[] = {
#define LIMIT(name, field, required) {name, offsetof(VkPhysicalDeviceLimits, field), required}
    LIMIT("image_side", maxImageDimension2D, 4096),
    LIMIT("image_layers", maxImageArrayLayers, 256),
    LIMIT("storage_range", maxStorageBufferRange, 1u << 27),
    LIMIT("uniform_range", maxUniformBufferRange, 16384),
    LIMIT("push_constants", maxPushConstantsSize, 128),
    LIMIT("allocations", maxMemoryAllocationCount, 4096),
    LIMIT("sets", maxBoundDescriptorSets, 4),
    LIMIT("resources", maxPerStageResources, 128),
    LIMIT("storage_images", maxPerStageDescriptorStorageImages, 4),
    LIMIT("storage_buffers", maxPerStageDescriptorStorageBuffers, 4),
    LIMIT("sampled_images", maxPerStageDescriptorSampledImages, 16),
    LIMIT("set_storage_images", maxDescriptorSetStorageImages, 24),
    LIMIT("set_storage_buffers", maxDescriptorSetStorageBuffers, 24),
    LIMIT("set_sampled_images", maxDescriptorSetSampledImages, 96),
    LIMIT("shared_memory", maxComputeSharedMemorySize, 16384),
    LIMIT("invocations", maxComputeWorkGroupInvocations, 128),
    LIMIT("group_width", maxComputeWorkGroupSize[0], 128),
    LIMIT("group_height", maxComputeWorkGroupSize[1], 128),
    LIMIT("group_depth", maxComputeWorkGroupSize[2], 64),
    LIMIT("groups_x", maxComputeWorkGroupCount[0], 65535),
    LIMIT("groups_y", maxComputeWorkGroupCount[1], 65535),
    LIMIT("groups_z", maxComputeWorkGroupCount[2], 65535),
#undef LIMIT
};

static void set_limit(VkPhysicalDeviceLimits *limits, size_t which, uint32_t value) {
    memcpy((char *)limits + LIMITS[which].offset, &value, sizeof value);
}

static void limit(VkPhysicalDeviceLimits *limits) {
    const char *wanted = wish("GUISE_LIMITS");
    if (!wanted) return;
    char *copy = strdup(wanted), *rest = NULL;
    for (char *part = strtok_r(copy, ",", &rest); part; part = strtok_r(NULL, ",", &rest)) {
        char *value = strchr(part, '=');
        if (value) *value++ = 0;
        int known = 0;
        for (size_t i = 0; i < sizeof LIMITS / sizeof *LIMITS; i++) {
            int is_minimum = !value && !strcmp(part, "minimum");
            if (is_minimum) set_limit(limits, i, LIMITS[i].required);
            if (value && !strcmp(part, LIMITS[i].name)) set_limit(limits, i, strtoul(value, NULL, 0)), known = 1;
            known |= is_minimum;
        }
        if (!strcmp(part, "minimum")) {
            limits->nonCoherentAtomSize = 256;
            limits->minStorageBufferOffsetAlignment = 256;
            limits->minUniformBufferOffsetAlignment = 256;
            limits->bufferImageGranularity = 131072;
            limits->timestampComputeAndGraphics = VK_FALSE;
        }
        if (!known) fprintf(stderr, "guise: no limit is called %s\n", part);
    }
    free(copy);
}

static void disguise(VkPhysicalDeviceProperties *properties) {
    const char *type = wish("GUISE_TYPE"), *version = wish("GUISE_VERSION");
    if (type) {
        static const char *const TYPES[] = {"other", "integrated", "discrete", "virtual", "cpu"};
        for (int i = 0; i < 5; i++)
            if (!strcmp(type, TYPES[i])) properties->deviceType = (VkPhysicalDeviceType)i;
    }
    unsigned major, minor;
    if (version && sscanf(version, "%u.%u", &major, &minor) == 2)
        properties->apiVersion = VK_MAKE_API_VERSION(0, major, minor, 0);
    limit(&properties->limits);
}

static VKAPI_ATTR void VKAPI_CALL get_properties(VkPhysicalDevice device, VkPhysicalDeviceProperties *properties) {
    instance_of(device)->properties(device, properties);
    disguise(properties);
}

static VKAPI_ATTR void VKAPI_CALL get_properties2(VkPhysicalDevice device, VkPhysicalDeviceProperties2 *properties) {
    instance_of(device)->properties2(device, properties);
    disguise(&properties->properties);
}

static VKAPI_ATTR VkResult VKAPI_CALL get_image_format(VkPhysicalDevice device, VkFormat format, VkImageType type,
                                                       VkImageTiling tiling, VkImageUsageFlags usage,
                                                       VkImageCreateFlags flags, VkImageFormatProperties *properties) {
    const char *without = wish("GUISE_WITHOUT_FORMAT");
    if (without && format == (VkFormat)atoi(without)) return VK_ERROR_FORMAT_NOT_SUPPORTED;
    VkResult result = instance_of(device)->image_format(device, format, type, tiling, usage, flags, properties);
    if (result == VK_SUCCESS && wish("GUISE_LIMITS")) {
        VkPhysicalDeviceProperties limited;
        get_properties(device, &limited);
        uint32_t side = limited.limits.maxImageDimension2D, layers = limited.limits.maxImageArrayLayers;
        if (properties->maxExtent.width > side) properties->maxExtent.width = side;
        if (properties->maxExtent.height > side) properties->maxExtent.height = side;
        if (properties->maxArrayLayers > layers) properties->maxArrayLayers = layers;
    }
    return result;
}

/* ------------------------------------------------------------------ memory of a device's own */

/* Types of memory that a discrete GPU has. All stand for the driver's first type, which the host can map. */
static const VkMemoryPropertyFlags TYPES_OF_MEMORY[] = {
    VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT,
    VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
    VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT | VK_MEMORY_PROPERTY_HOST_CACHED_BIT,
};
enum { TYPE_COUNT = sizeof TYPES_OF_MEMORY / sizeof *TYPES_OF_MEMORY };

static void divide(VkPhysicalDeviceMemoryProperties *memory) {
    if (!wish("GUISE_MEMORY")) return;
    memory->memoryTypeCount = TYPE_COUNT;
    for (uint32_t i = 0; i < TYPE_COUNT; i++)
        memory->memoryTypes[i] = (VkMemoryType){.propertyFlags = TYPES_OF_MEMORY[i], .heapIndex = i > 0};
    memory->memoryHeapCount = 2;
    memory->memoryHeaps[1] = (VkMemoryHeap){.size = memory->memoryHeaps[0].size};
}

static VKAPI_ATTR void VKAPI_CALL get_memory(VkPhysicalDevice device, VkPhysicalDeviceMemoryProperties *memory) {
    instance_of(device)->memory(device, memory);
    divide(memory);
}

static VKAPI_ATTR void VKAPI_CALL get_memory2(VkPhysicalDevice device, VkPhysicalDeviceMemoryProperties2 *memory) {
    instance_of(device)->memory2(device, memory);
    divide(&memory->memoryProperties);
}

static void allow_all(VkMemoryRequirements *needed) {
    if (wish("GUISE_MEMORY")) needed->memoryTypeBits = (1u << TYPE_COUNT) - 1;
}

static VKAPI_ATTR void VKAPI_CALL of_buffer(VkDevice device, VkBuffer buffer, VkMemoryRequirements *needed) {
    device_of(device)->of_buffer(device, buffer, needed);
    allow_all(needed);
}

static VKAPI_ATTR void VKAPI_CALL of_buffer2(VkDevice device, const VkBufferMemoryRequirementsInfo2 *info,
                                             VkMemoryRequirements2 *needed) {
    device_of(device)->of_buffer2(device, info, needed);
    allow_all(&needed->memoryRequirements);
}

static VKAPI_ATTR void VKAPI_CALL of_image(VkDevice device, VkImage image, VkMemoryRequirements *needed) {
    device_of(device)->of_image(device, image, needed);
    allow_all(needed);
}

static VKAPI_ATTR void VKAPI_CALL of_image2(VkDevice device, const VkImageMemoryRequirementsInfo2 *info,
                                            VkMemoryRequirements2 *needed) {
    device_of(device)->of_image2(device, info, needed);
    allow_all(&needed->memoryRequirements);
}

/* ------------------------------------------------------------------ instances and devices */

static VKAPI_ATTR VkResult VKAPI_CALL create_instance(const VkInstanceCreateInfo *info,
                                                      const VkAllocationCallbacks *allocator, VkInstance *made) {
    VkLayerInstanceCreateInfo *link = (void *)info->pNext;
    while (link && !(link->sType == VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO &&
                     link->function == VK_LAYER_LINK_INFO))
        link = (void *)link->pNext;
    if (!link) return VK_ERROR_INITIALIZATION_FAILED;
    PFN_vkGetInstanceProcAddr get = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    VkResult result = ((PFN_vkCreateInstance)get(NULL, "vkCreateInstance"))(info, allocator, made);
    if (result != VK_SUCCESS) return result;
    Instance *new = calloc(1, sizeof *new);
    *new = (Instance){
        .key = key_of(*made),
        .handle = *made,
        .get = get,
        .destroy = (void *)get(*made, "vkDestroyInstance"),
        .properties = (void *)get(*made, "vkGetPhysicalDeviceProperties"),
        .properties2 = (void *)get(*made, "vkGetPhysicalDeviceProperties2"),
        .image_format = (void *)get(*made, "vkGetPhysicalDeviceImageFormatProperties"),
        .features = (void *)get(*made, "vkGetPhysicalDeviceFeatures"),
        .memory = (void *)get(*made, "vkGetPhysicalDeviceMemoryProperties"),
        .memory2 = (void *)get(*made, "vkGetPhysicalDeviceMemoryProperties2"),
    };
    pthread_mutex_lock(&lock);
    new->next = instances;
    instances = new;
    pthread_mutex_unlock(&lock);
    return result;
}

static VKAPI_ATTR void VKAPI_CALL destroy_instance(VkInstance handle, const VkAllocationCallbacks *allocator) {
    if (!handle) return;
    Instance *gone = instance_of(handle);
    pthread_mutex_lock(&lock);
    Instance **at = &instances;
    while (*at != gone) at = &(*at)->next;
    *at = gone->next;
    pthread_mutex_unlock(&lock);
    gone->destroy(handle, allocator);
    free(gone);
}

static VKAPI_ATTR VkResult VKAPI_CALL create_device(VkPhysicalDevice physical, const VkDeviceCreateInfo *info,
                                                    const VkAllocationCallbacks *allocator, VkDevice *made) {
    VkLayerDeviceCreateInfo *link = (void *)info->pNext;
    while (link && !(link->sType == VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO &&
                     link->function == VK_LAYER_LINK_INFO))
        link = (void *)link->pNext;
    if (!link) return VK_ERROR_INITIALIZATION_FAILED;
    PFN_vkGetInstanceProcAddr get_of_instance = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    PFN_vkGetDeviceProcAddr get = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    Instance *instance = instance_of(physical);
    VkDeviceCreateInfo wider = *info;
    VkPhysicalDeviceFeatures features, offered;
    if (wish("GUISE_MODULES") && info->pEnabledFeatures) {
        /* Fused products are computed in double precision. */
        instance->features(physical, &offered);
        features = *info->pEnabledFeatures;
        features.shaderFloat64 |= offered.shaderFloat64;
        wider.pEnabledFeatures = &features;
    }
    PFN_vkCreateDevice create = (void *)get_of_instance(instance->handle, "vkCreateDevice");
    VkResult result = create(physical, &wider, allocator, made);
    if (result != VK_SUCCESS) return result;
    Device *new = calloc(1, sizeof *new);
    *new = (Device){
        .key = key_of(*made),
        .handle = *made,
        .get = get,
        .destroy = (void *)get(*made, "vkDestroyDevice"),
        .create_module = (void *)get(*made, "vkCreateShaderModule"),
        .destroy_module = (void *)get(*made, "vkDestroyShaderModule"),
        .create_pipelines = (void *)get(*made, "vkCreateComputePipelines"),
        .allocate = (void *)get(*made, "vkAllocateMemory"),
        .of_buffer = (void *)get(*made, "vkGetBufferMemoryRequirements"),
        .of_buffer2 = (void *)get(*made, "vkGetBufferMemoryRequirements2"),
        .of_image = (void *)get(*made, "vkGetImageMemoryRequirements"),
        .of_image2 = (void *)get(*made, "vkGetImageMemoryRequirements2"),
        .map = (void *)get(*made, "vkMapMemory"),
        .unmap = (void *)get(*made, "vkUnmapMemory"),
    };
    pthread_mutex_lock(&lock);
    new->next = devices;
    devices = new;
    pthread_mutex_unlock(&lock);
    return result;
}

static VKAPI_ATTR void VKAPI_CALL destroy_device(VkDevice handle, const VkAllocationCallbacks *allocator) {
    if (!handle) return;
    Device *gone = device_of(handle);
    pthread_mutex_lock(&lock);
    Device **at = &devices;
    while (*at != gone) at = &(*at)->next;
    *at = gone->next;
    pthread_mutex_unlock(&lock);
    gone->destroy(handle, allocator);
    free(gone);
}

/* ------------------------------------------------------------------ other shaders */

static uint64_t fnv1a(const void *bytes, size_t size, uint64_t hash) {
    for (size_t i = 0; i < size; i++) hash = (hash ^ ((const uint8_t *)bytes)[i]) * 0x100000001b3u;
    return hash;
}
#define FNV_START 0xcbf29ce484222325u

/* Returns a file's content, which the caller frees, or NULL if there is none. */
static uint32_t *read_file(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    if (!file) return NULL;
    fseek(file, 0, SEEK_END);
    *size = (size_t)ftell(file);
    rewind(file);
    uint32_t *content = malloc(*size);
    size_t had = fread(content, 1, *size, file);
    fclose(file);
    if (had == *size) return content;
    free(content);
    return NULL;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_module(VkDevice handle, const VkShaderModuleCreateInfo *info,
                                                    const VkAllocationCallbacks *allocator, VkShaderModule *made) {
    VkShaderModuleCreateInfo other = *info;
    uint32_t *code = NULL;
    const char *folder = wish("GUISE_MODULES");
    if (folder) {
        char path[4096];
        unsigned long long hash = fnv1a(info->pCode, info->codeSize, FNV_START);
        snprintf(path, sizeof path, "%s/%016llx.spv", folder, hash);
        code = read_file(path, &other.codeSize);
        if (code)
            other.pCode = code;
        else
            other.codeSize = info->codeSize;
    }
    VkResult result = device_of(handle)->create_module(handle, &other, allocator, made);
    if (result == VK_SUCCESS && wish("GUISE_FOLD")) {
        Module *new = calloc(1, sizeof *new);
        *new = (Module){.handle = *made, .code = malloc(other.codeSize), .size = other.codeSize};
        memcpy(new->code, other.pCode, other.codeSize);
        pthread_mutex_lock(&lock);
        new->next = modules;
        modules = new;
        pthread_mutex_unlock(&lock);
    }
    free(code);
    return result;
}

static VKAPI_ATTR void VKAPI_CALL destroy_module(VkDevice handle, VkShaderModule gone,
                                                 const VkAllocationCallbacks *allocator) {
    pthread_mutex_lock(&lock);
    Module **at = &modules;
    while (*at && (*at)->handle != gone) at = &(*at)->next;
    Module *found = *at;
    if (found) *at = found->next;
    pthread_mutex_unlock(&lock);
    if (found) free(found->code), free(found);
    device_of(handle)->destroy_module(handle, gone, allocator);
}

/* Returns the code of a module with these constants folded in, or NULL if that fails. The caller frees the code. */
static uint32_t *fold(const Module *module, const VkSpecializationInfo *constants, size_t *size) {
    char values[1024] = "", path[512], command[8192];
    size_t end = 0;
    for (uint32_t i = 0; constants && i < constants->mapEntryCount; i++) {
        const VkSpecializationMapEntry *entry = &constants->pMapEntries[i];
        int32_t value;
        memcpy(&value, (const char *)constants->pData + entry->offset, sizeof value);
        end += (size_t)snprintf(values + end, sizeof values - end, "%u:%d ", entry->constantID, value);
    }
    unsigned long long hash = fnv1a(values, end, fnv1a(module->code, module->size, FNV_START));
    snprintf(path, sizeof path, "%s/%016llx", wish("GUISE_FOLD"), hash);
    char folded[600], given[600];
    snprintf(folded, sizeof folded, "%s.spv", path);
    uint32_t *code = read_file(folded, size);
    if (code) return code;
    snprintf(given, sizeof given, "%s.%d.in", path, (int)getpid());
    FILE *file = fopen(given, "wb");
    if (!file) return NULL;
    fwrite(module->code, 1, module->size, file);
    fclose(file);
    /* The layer's environment variables do not affect the programs that it runs. */
    snprintf(command, sizeof command,
             "spirv-opt %s%s%s --freeze-spec-const --fold-spec-const-op-composite --unify-const --ccp "
             "--eliminate-dead-branches --merge-blocks -O '%s' -o '%s.out' && mv '%s.out' '%s'; rm -f '%s'",
             end ? "--set-spec-const-default-value '" : "", values, end ? "'" : "", given, given, given, folded, given);
    if (system(command) != 0) fprintf(stderr, "guise: failed: %s\n", command);
    return read_file(folded, size);
}

static VKAPI_ATTR VkResult VKAPI_CALL create_pipelines(VkDevice handle, VkPipelineCache cache, uint32_t count,
                                                       const VkComputePipelineCreateInfo *infos,
                                                       const VkAllocationCallbacks *allocator, VkPipeline *made) {
    Device *device = device_of(handle);
    VkResult result = VK_SUCCESS;
    for (uint32_t i = 0; i < count; i++) {
        VkComputePipelineCreateInfo info = infos[i];
        VkShaderModule other = VK_NULL_HANDLE;
        pthread_mutex_lock(&lock);
        Module *module = modules;
        while (module && module->handle != info.stage.module) module = module->next;
        VkShaderModuleCreateInfo folded = {.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
        uint32_t *code = module ? fold(module, info.stage.pSpecializationInfo, &folded.codeSize) : NULL;
        pthread_mutex_unlock(&lock);
        folded.pCode = code;
        if (code && device->create_module(handle, &folded, NULL, &other) == VK_SUCCESS) {
            info.stage.module = other;
            info.stage.pSpecializationInfo = NULL;
        }
        free(code);
        VkResult one = device->create_pipelines(handle, cache, 1, &info, allocator, &made[i]);
        if (one != VK_SUCCESS) made[i] = VK_NULL_HANDLE, result = one;
        if (other) device->destroy_module(handle, other, NULL);
    }
    return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL allocate_memory(VkDevice handle, const VkMemoryAllocateInfo *info,
                                                      const VkAllocationCallbacks *allocator, VkDeviceMemory *made) {
    Device *device = device_of(handle);
    VkMemoryAllocateInfo of_driver = *info;
    if (wish("GUISE_MEMORY")) of_driver.memoryTypeIndex = 0;
    VkResult result = device->allocate(handle, &of_driver, allocator, made);
    const char *poison = wish("GUISE_POISON");
    void *at;
    if (result == VK_SUCCESS && poison &&
        device->map(handle, *made, 0, VK_WHOLE_SIZE, 0, &at) == VK_SUCCESS) {
        uint32_t word = (uint32_t)strtoul(poison, NULL, 0);
        for (VkDeviceSize i = 0; i < info->allocationSize / sizeof word; i++) ((uint32_t *)at)[i] = word;
        device->unmap(handle, *made);
    }
    return result;
}

/* ------------------------------------------------------------------ the loader's entry points */

typedef struct {
    const char *name;
    void *function;
} Function;

static void *find(const Function *functions, const char *name) {
    while (functions->name && strcmp(functions->name, name)) functions++;
    return functions->function;
}

static const Function OF_DEVICES[] = {
    {"vkDestroyDevice", destroy_device},
    {"vkCreateShaderModule", create_module},
    {"vkDestroyShaderModule", destroy_module},
    {"vkCreateComputePipelines", create_pipelines},
    {"vkAllocateMemory", allocate_memory},
    {"vkGetBufferMemoryRequirements", of_buffer},
    {"vkGetBufferMemoryRequirements2", of_buffer2},
    {"vkGetBufferMemoryRequirements2KHR", of_buffer2},
    {"vkGetImageMemoryRequirements", of_image},
    {"vkGetImageMemoryRequirements2", of_image2},
    {"vkGetImageMemoryRequirements2KHR", of_image2},
    {NULL, NULL},
};

static const Function OF_INSTANCES[] = {
    {"vkCreateInstance", create_instance},
    {"vkDestroyInstance", destroy_instance},
    {"vkCreateDevice", create_device},
    {"vkGetPhysicalDeviceProperties", get_properties},
    {"vkGetPhysicalDeviceProperties2", get_properties2},
    {"vkGetPhysicalDeviceProperties2KHR", get_properties2},
    {"vkGetPhysicalDeviceImageFormatProperties", get_image_format},
    {"vkGetPhysicalDeviceMemoryProperties", get_memory},
    {"vkGetPhysicalDeviceMemoryProperties2", get_memory2},
    {"vkGetPhysicalDeviceMemoryProperties2KHR", get_memory2},
    {NULL, NULL},
};

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL get_device_function(VkDevice handle, const char *name) {
    if (!strcmp(name, "vkGetDeviceProcAddr")) return (PFN_vkVoidFunction)get_device_function;
    void *ours = find(OF_DEVICES, name);
    return ours ? (PFN_vkVoidFunction)ours : device_of(handle)->get(handle, name);
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL get_instance_function(VkInstance handle, const char *name) {
    if (!strcmp(name, "vkGetInstanceProcAddr")) return (PFN_vkVoidFunction)get_instance_function;
    if (!strcmp(name, "vkGetDeviceProcAddr")) return (PFN_vkVoidFunction)get_device_function;
    void *ours = find(OF_INSTANCES, name);
    if (!ours) ours = find(OF_DEVICES, name);
    if (ours) return (PFN_vkVoidFunction)ours;
    return handle ? instance_of(handle)->get(handle, name) : NULL;
}

VKAPI_ATTR VkResult VKAPI_CALL vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface *with) {
    with->loaderLayerInterfaceVersion = 2;
    with->pfnGetInstanceProcAddr = get_instance_function;
    with->pfnGetDeviceProcAddr = get_device_function;
    with->pfnGetPhysicalDeviceProcAddr = NULL;
    return VK_SUCCESS;
}
