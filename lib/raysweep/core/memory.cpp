#include "raysweep/core/memory.h"

#include <unistd.h>

#include <fstream>
#include <string>

namespace raysweep {
namespace {

/// A line "VmHWM:   1234 kB" of Linux's /proc/self/status.
std::size_t statusBytes(const std::string& key) {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.rfind(key + ":", 0) == 0) return std::size_t(std::stoull(line.substr(key.size() + 1))) * 1024;
    return 0;
}

}  // namespace

std::size_t residentBytes() {
    return statusBytes("VmRSS");
}

std::size_t peakResidentBytes() {
    return statusBytes("VmHWM");
}

std::size_t physicalBytes() {
    return std::size_t(sysconf(_SC_PHYS_PAGES)) * std::size_t(sysconf(_SC_PAGE_SIZE));
}

void resetPeak() {
    std::ofstream("/proc/self/clear_refs") << "5";
}

}  // namespace raysweep
