/// Kernels are compiled for several instruction sets; the best that the machine has is taken at run time.
#pragma once

#include <functional>

namespace raysweep::test {

/// Calls `use` once for each instruction set that kernels were compiled for and the machine has, kernels taking that
/// one, within a SCOPED_TRACE of its name.
void forEachInstructionSet(const std::function<void()>& use);

}  // namespace raysweep::test
