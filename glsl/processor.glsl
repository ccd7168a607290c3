// Processors run some invocations in the lanes of a vector, and all of them through each branch that one takes; they run
// workgroups one after another.

#ifndef PROCESSOR_GLSL
#define PROCESSOR_GLSL
// Whether the device computes on a processor's cores.
layout(constant_id = 13) const int ON_PROCESSOR = 0;
#endif
