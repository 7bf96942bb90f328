/// Which of the numbers per voxel, and which of the volumes, is meant where a file holds several.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace raysweep {

/// Both are counted from 0. Not given: the file must hold just one.
struct VolumeChoice {
    std::optional<int> channel;  ///< of the numbers per voxel: colours, components of vectors, stained dyes
    std::optional<int>
        volumeIndex;  ///< of the volumes: instants, echoes, parts; those of one instant follow each other
};

/// What a file holds several of.
struct Several {
    std::uint64_t count = 1;
    std::string what;                             ///< "channels (RGB-color)", "volumes of 3x4x5"
    std::function<std::string(int number)> name;  ///< what the file calls one of them; may be empty
};

/// The one that is meant. @throw InvalidArgument if there is none of this number, or if there are several and none was
/// chosen: it lists them.
int chooseChannel(const std::string& path, const Several& channels, const VolumeChoice& choice);
int chooseVolume(const std::string& path, const Several& volumes, const VolumeChoice& choice);

}  // namespace raysweep
