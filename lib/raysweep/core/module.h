/// Parts of the library that are loaded when they are needed.
#pragma once

#include <string>

namespace raysweep {

/// A function of a module, or why there is none.
struct ModuleFunction {
    void* address = nullptr;
    std::string problem;
};

/// The function `symbol` of the shared library `name`.so: beside the running program, in its ../lib/raysweep, or in
/// the folders that were named when this library was built. A module that was loaded stays.
ModuleFunction moduleFunction(const std::string& name, const char* symbol);

}  // namespace raysweep
