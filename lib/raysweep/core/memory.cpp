#include "raysweep/core/memory.h"

#include "raysweep/core/brief.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>
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
    static const std::size_t bytes = [] {
        std::ifstream groups("/proc/self/cgroup");
        const double machine = double(sysconf(_SC_PHYS_PAGES)) * double(sysconf(_SC_PAGE_SIZE));
        return std::size_t(std::min(machine, groupLimit(groups, "/sys/fs/cgroup")));
    }();
    return bytes;
}

double groupLimit(std::istream& groups, const std::string& root) {
    double least = std::numeric_limits<double>::infinity();
    for (std::string line; std::getline(groups, line);) {  // "4:memory:/a/b" (version 1), "0::/a/b" (version 2)
        const std::size_t first = line.find(':'), second = line.find(':', first + 1);
        if (second == std::string::npos) continue;
        const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
        const bool unified = controllers == ",,";
        if (!unified && controllers.find(",memory,") == std::string::npos) continue;
        const std::string folder = unified ? root : root + "/memory";
        const char* const file = unified ? "/memory.max" : "/memory.limit_in_bytes";
        // In a container the path may be the host's, and only what is above it exists.
        for (std::string path = line.substr(second + 1);; path.erase(path.find_last_of('/'))) {
            double limit = 0;
            if (std::ifstream(folder + path + file) >> limit) least = std::min(least, limit);
            if (path.find('/') == std::string::npos) break;
        }
    }
    return least;
}

void resetPeak() {
    std::ofstream("/proc/self/clear_refs") << "5";
}

void requireBytes(double bytes, const std::string& what, const std::string& instead, Remedy remedy) {
    const auto available = double(physicalBytes());
    if (bytes > available)
        throw InvalidArgument(
            what + " " + brief(bytes / 1e9, 3) + " GB, there are " + brief(available / 1e9, 3) + " GB; " + instead,
            remedy);
}

void requireMemory(double blocks, std::size_t bytesPerVoxel) {
    constexpr int kBlockVoxels = 8 * 8 * 8;
    requireBytes(blocks * kBlockVoxels * double(bytesPerVoxel),
                 "the volume's " + std::to_string(std::size_t(blocks)) + " blocks of 8x8x8 voxels need",
                 "use a coarser grid");
}

}  // namespace raysweep
