// Prints the names of the Vulkan devices, one per line, with the layers in the
// arguments enabled. Fails with a message if the loader, a layer or a device is
// missing. It declares the few parts of Vulkan that it uses, so that no headers
// need to be installed.
#include <cstdint>
#include <cstdio>
#include <dlfcn.h>
#include <vector>

struct InstanceCreateInfo {
    int32_t type = 1; // VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO
    const void *next = nullptr;
    uint32_t flags = 0;
    const void *application = nullptr;
    uint32_t layer_count = 0;
    const char *const *layers = nullptr;
    uint32_t extension_count = 0;
    const char *const *extensions = nullptr;
};

struct PhysicalDeviceProperties {
    uint32_t versions_and_ids[5];
    char name[256];
    uint64_t rest[128]; // more than the 550 bytes that follow
};

int main(int count, char **arguments) {
    void *loader = dlopen("libvulkan.so.1", RTLD_NOW);
    if (!loader) {
        std::fprintf(stderr, "no Vulkan loader: %s\n", dlerror());
        return 1;
    }
    auto create = (int (*)(const InstanceCreateInfo *, const void *, void **))dlsym(loader, "vkCreateInstance");
    auto enumerate = (int (*)(void *, uint32_t *, void **))dlsym(loader, "vkEnumeratePhysicalDevices");
    auto properties = (void (*)(void *, PhysicalDeviceProperties *))dlsym(loader, "vkGetPhysicalDeviceProperties");

    InstanceCreateInfo info;
    info.layer_count = count - 1;
    info.layers = arguments + 1;
    void *instance = nullptr;
    int status = create(&info, nullptr, &instance);
    if (status != 0) {
        const char *why = status == -6 ? ": a layer is missing" : status == -9 ? ": no driver found" : "";
        std::fprintf(stderr, "vkCreateInstance returned %d%s\n", status, why);
        return 1;
    }
    uint32_t devices = 0;
    status = enumerate(instance, &devices, nullptr);
    std::vector<void *> handles(devices);
    if (status != 0 || devices == 0 || enumerate(instance, &devices, handles.data()) != 0) {
        std::fprintf(stderr, "no Vulkan device (status %d)\n", status);
        return 1;
    }
    for (void *handle : handles) {
        PhysicalDeviceProperties found = {};
        properties(handle, &found);
        std::puts(found.name);
    }
}
