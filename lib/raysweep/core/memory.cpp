#include "raysweep/core/memory.h"

#include "raysweep/core/error.h"

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

void requireBytes(double bytes, const std::string& what, const std::string& instead) {
    const auto available = double(physicalBytes());
    if (bytes > available)
        throw InvalidArgument(what + " " + std::to_string(std::size_t(bytes / 1e9)) + " GB, this machine has " +
                              std::to_string(std::size_t(available / 1e9)) + " GB; " + instead);
}

void requireMemory(double blocks, std::size_t bytesPerVoxel) {
    constexpr int kBlockVoxels = 8 * 8 * 8;
    requireBytes(blocks * kBlockVoxels * double(bytesPerVoxel),
                 "the volume's " + std::to_string(std::size_t(blocks)) + " blocks of 8x8x8 voxels need",
                 "use a coarser grid");
}

}  // namespace raysweep
