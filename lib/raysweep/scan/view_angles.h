/// At what angles the views of a scan are, as files say it: numbers, and maybe their unit.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace raysweep {

enum class AngleUnit { degrees, radians };

/// Angles of views, one for each.
struct ViewAngles {
    std::vector<double> degrees;
    std::string said;  ///< what was taken for granted about their unit, or looks amiss; empty: nothing
};

/// In degrees what a file has. The unit is what `asked` says; else what the file calls it ("rad", "radians", "deg",
/// "degrees", "°"); else radians if the angles, of which some are no whole numbers, cover 150 degrees to a turn as
/// radians: a scan of 2.6 to 6.6 degrees would be none. Else degrees.
/// @param units as the file calls them; may be empty
ViewAngles viewAngles(std::vector<double> numbers, const std::string& units, const std::optional<AngleUnit>& asked);

/// Numbers from a text file, separated by white space, commas or semicolons; a # begins a comment.
/// @throw IoError naming the file, and the line of what is no finite number, or if there is no number at all.
std::vector<double> readAngleFile(const std::string& path);

}  // namespace raysweep
