/// Looks into a volume: three sections through one voxel, each across one axis, as a picture or as a page.
#pragma once

#include "raysweep/formats/dense_source.h"
#include "raysweep/image/image.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace raysweep {

/// From black to white, in units of the grid.
struct GreyWindow {
    double low = 0, high = 1;
};

struct SectionOptions {
    std::optional<Vec3> at;            ///< world, within the volume; not given: its middle
    std::optional<GreyWindow> window;  ///< finite, low below high; not given: from the smallest to the largest value

    /// @throw InvalidArgument naming field, value and bound
    void validate() const;
};

/// A section across axis `normal`, shown with axis `right` to the right and `up` upwards.
struct SectionAxes {
    int normal, right, up;
};
constexpr std::array<SectionAxes, 3> kSectionAxes{{{2, 0, 1}, {1, 0, 2}, {0, 1, 2}}};

struct Sections {
    DenseLayout layout;
    Index3 corner{0};  ///< the grid's index of sample (0,0,0)
    Index3 at{0};      ///< the sample that all three go through, counted from the corner
    GreyWindow window;
    double smallest = 0, largest = 0;          ///< of all samples
    std::array<std::vector<float>, 3> planes;  ///< as kSectionAxes; dims[right] * dims[up] samples, `right` fastest
};

/// Reads the source once, from its first slice to its last.
/// @throw InvalidArgument if `at` is outside of the volume, and as DenseSource::slice does
Sections sectionsOf(DenseSource& source, const SectionOptions& options = {});

/// The three side by side in their true proportions, under each other's scale, with their axes and where they are, a
/// scale bar with its length in world units, and the window. Where all axes of the grid are the world's, they are
/// called x, y, z, with a minus if they run the other way, else i, j, k. Three equal channels. A voxel has at least a
/// pixel unless the picture would be larger than 4096 pixels.
Image sectionPicture(const Sections& sections);

/// One HTML file that needs nothing else: three sections to scroll through, the value under the pointer, and the window
/// to be changed. It holds all voxels in 8 bits, from the smallest value to the largest, or from one end of the
/// window that is given to the other. The file appears whole or not at all.
/// @throw InvalidArgument for more than 2^30 voxels, and as sectionsOf does
/// @throw IoError if it cannot be written
void writeSectionPage(const std::string& path, DenseSource& source, const SectionOptions& options,
                      const Sections& sections);

/// "x", "-x" or "i" of an axis: see sectionPicture.
std::string axisName(const DenseLayout& layout, int axis);

/// The length of a scale bar, 1, 2 or 5 times a power of ten and at most `longest`.
double scaleLength(double longest);

}  // namespace raysweep
