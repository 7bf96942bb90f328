#include "raysweep/core/module.h"

#include <dlfcn.h>

#include <algorithm>
#include <filesystem>
#include <vector>

namespace fs = std::filesystem;

namespace raysweep {
namespace {

std::vector<fs::path> foldersToSearch() {
    std::vector<fs::path> folders;
    std::error_code failed;
    const fs::path program = fs::read_symlink("/proc/self/exe", failed);
    if (!failed) {
        folders.push_back(program.parent_path());
        folders.push_back(program.parent_path().parent_path() / "lib" / "raysweep");
    }
    const std::string builtIn = RAYSWEEP_MODULE_FOLDERS;  // separated by colons
    for (std::size_t begin = 0; begin < builtIn.size();) {
        const std::size_t end = std::min(builtIn.find(':', begin), builtIn.size());
        if (end > begin) folders.push_back(builtIn.substr(begin, end - begin));
        begin = end + 1;
    }
    return folders;
}

}  // namespace

ModuleFunction moduleFunction(const std::string& name, const char* symbol) {
    const std::string file = name + ".so";
    std::string searched;
    for (const fs::path& folder : foldersToSearch()) {
        const fs::path path = folder / file;
        std::error_code ignored;
        searched += (searched.empty() ? "'" : ", '") + folder.string() + "'";
        if (!fs::exists(path, ignored)) continue;
        void* const module = ::dlopen(path.c_str(), RTLD_LAZY | RTLD_LOCAL);
        void* const address = module ? ::dlsym(module, symbol) : nullptr;
        if (address) return {address, ""};
        const char* const why = ::dlerror();
        return {nullptr, "'" + path.string() + "' could not be loaded: " + (why ? why : "unknown error")};
    }
    return {nullptr, "the module '" + file + "' is not in any of " + searched + "; build or install it again"};
}

}  // namespace raysweep
