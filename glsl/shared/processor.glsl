// Tells whether the device is a CPU. A CPU runs some invocations in the lanes of a vector, and runs all of
// them through each branch that one of them takes. It runs workgroups one after another.

#ifndef PROCESSOR_GLSL
#define PROCESSOR_GLSL
// Whether the device computes on the cores of a CPU.
layout(constant_id = 13) const int ON_PROCESSOR = 0;
#endif
