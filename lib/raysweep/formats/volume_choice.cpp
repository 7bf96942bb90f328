#include "raysweep/formats/volume_choice.h"

#include "raysweep/core/error.h"

#include <algorithm>

namespace raysweep {
namespace {

/// "0 red, 1 green, 2 blue"; only numbers where they have no names; not more than a page can hold.
std::string listOf(const Several& several) {
    constexpr std::uint64_t kMost = 40;
    const std::uint64_t last = several.count - 1;
    if (!several.name) return "0 to " + std::to_string(last);
    std::string list;
    for (std::uint64_t n = 0; n < std::min(several.count, kMost); ++n)
        list += (n > 0 ? ", " : "") + std::to_string(n) + " " + several.name(int(n));
    return several.count > kMost ? list + ", ... up to " + std::to_string(last) : list;
}

int choose(const std::string& path, const Several& several, const std::optional<int>& wanted, const std::string& field,
           const std::string& why) {
    const std::string holds = "'" + path + "' holds " + std::to_string(several.count) + " " + several.what;
    if (!wanted) {
        if (several.count == 1) return 0;
        throw InvalidArgument(holds + ", " + why + "; choose one by `" + field + "`: " + listOf(several));
    }
    if (*wanted >= 0 && std::uint64_t(*wanted) < several.count) return *wanted;
    InvalidArgument error(
        field + " " + std::to_string(*wanted) + ": " +
        (several.count > 1 ? holds + ": " + listOf(several) : "'" + path + "' holds one, which has the number 0"));
    error.subject = field;
    throw error;
}

}  // namespace

int chooseChannel(const std::string& path, const Several& channels, const VolumeChoice& choice) {
    return choose(path, channels, choice.channel, "channel", "but a volume needs one number per voxel");
}

int chooseVolume(const std::string& path, const Several& volumes, const VolumeChoice& choice) {
    return choose(path, volumes, choice.volumeIndex, "volumeIndex", "and one is wanted");
}

}  // namespace raysweep
