/* Compiles if there is a compiler that finds the headers of Vulkan. */
#include <vulkan/vulkan_core.h>
