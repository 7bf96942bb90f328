#include "raysweep/camera/matting_choice.h"

#include "raysweep/image/image_io.h"

#include <algorithm>

namespace raysweep {

std::optional<MattingOptions::Matting> evidentMatting(const Poses& poses) {
    const auto all = [&](const auto& has) { return std::all_of(poses.views.begin(), poses.views.end(), has); };
    if (all([](const Pose& pose) { return !pose.image.empty() && pictureHasAlpha(pose.image); }))
        return MattingOptions::Matting::alpha;
    if (all([](const Pose& pose) { return !pose.onWhite.empty() && !pose.onBlack.empty(); }))
        return MattingOptions::Matting::whiteBlack;
    if (all([](const Pose& pose) { return !pose.mask.empty(); })) return MattingOptions::Matting::masks;
    return std::nullopt;
}

}  // namespace raysweep
