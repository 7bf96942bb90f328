/// Projections in files: one volume whose slices are the views, or pictures, one for each view.
#pragma once

#include "raysweep/camera/projections.h"
#include "raysweep/core/progress.h"
#include "raysweep/core/sample_type.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace raysweep {

/// World units along columns and rows.
using DetectorPair = std::array<double, 2>;

struct ProjectionFile {
    Projections projections;
    /// From a pixel to the one in the next column and in the next row; negative where the file counts backwards. Only
    /// volumes (MetaImage, NRRD) have it, and only if their axes are not turned.
    std::optional<DetectorPair> spacing;
    std::optional<DetectorPair> origin;     ///< centre of the pixel in column 0, row 0, likewise
    SampleType type = SampleType::float32;  ///< of the numbers in the file
    std::string format;                     ///< "MetaImage", "NRRD", "pictures"
    bool complete = true;                   ///< false if reading was stopped: then values are missing
};

struct ProjectionReadOptions {
    bool repair = false;          ///< NaN and infinities become NaN, "not measured", instead of an error
    bool unsignedCounts = false;  ///< see DataExchangeOptions
};

/// Reads one volume (.mha, .mhd, .nrrd, .nhdr; its axes are columns, rows and views), grey pictures (TIFF, EXR, PNG
/// ...) in natural order of their names, one view each, or all pages of one file; or one folder that holds pictures.
/// Values are those of the file whatever their type: not decoded, not scaled.
/// @throw InvalidArgument for values that are NaN or infinite (it names the first) unless `repair` is set, or of a
/// wrong number type (requireCounts) unless `unsignedCounts` is, pictures that differ in size or type or have colour,
/// and files that are no projections.
/// @throw IoError if files are missing, malformed, truncated, or of a kind that is not known.
ProjectionFile readProjections(const std::vector<std::string>& files, const ProjectionReadOptions& options = {},
                               const ProgressCallback& progress = {});

/// What is NaN or infinite: becomes NaN, "not measured", if `repair`.
/// @throw InvalidArgument else, naming `path` and the first of them.
void requireMeasured(Projections& projections, const std::string& path, bool repair);

/// The same of pictures (slices of a volume) that hold one detector row each, their rows being views: sinograms. Rows
/// are as far apart as columns then, and centred.
ProjectionFile fromSinograms(const ProjectionFile& sinograms);

/// Writes 32 bit floats by extension: `.mha` one MetaImage, whose axes are columns, rows and views; `.exr` one picture
/// for each view, name.exr becoming name_0001.exr and so on. A file appears whole or not at all; of pictures, those
/// before the one that failed stay.
/// @param spacing,origin of the pixels, for `.mha` only; without them 1, and what puts the detector's middle at 0.
/// @throw InvalidArgument if there are no values, or not as many as columns x rows x views.
/// @throw IoError if the extension is another one, or a file cannot be written.
void writeProjections(const std::string& path, const Projections& projections,
                      const std::optional<DetectorPair>& spacing = {}, const std::optional<DetectorPair>& origin = {});

/// The files that `writeProjections` makes of `path`.
std::vector<std::string> projectionFiles(const std::string& path, int views);

}  // namespace raysweep
