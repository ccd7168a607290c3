// Tells whether the device is a CPU. A CPU runs some invocations in the lanes of a vector, and runs all of
// them through each branch that one of them takes. It runs workgroups one after another.

// Whether the device computes on the cores of a CPU.
layout(constant_id = 13) const int ON_PROCESSOR = 0;
