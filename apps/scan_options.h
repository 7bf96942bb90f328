/// How an object was, or is to be, X-rayed: what `raysweep project` and `raysweep ct` share.
#pragma once

#include "cli.h"

#include "raysweep/camera/projection_geometry.h"
#include "raysweep/scan/projection_io.h"

#include <optional>
#include <string>
#include <vector>

namespace raysweep::apps {

/// What the user typed; empty text: not given.
struct ScanArguments {
    std::string geometry, cone, detector, pitch, center;
    bool parallel = false;
    int views = 0;  ///< 0: not given
    double firstAngle = 0;
    std::optional<double> arc, axisColumn, centerRow;
};

void addScanOptions(CLI::App& app, ScanArguments& arguments);

/// Checks what can be checked without a file. @throw CLI::ValidationError
void checkScanOptions(const ScanArguments& arguments);

/// What projections that are there say about their scan.
struct MeasuredScan {
    int width = 0, height = 0, views = 0;
    std::optional<DetectorPair> spacing, origin;  ///< world units
    std::vector<double> angles;                   ///< degrees; empty if not known
};

/// Projections are written as `.mha` or numbered `.exr`. @throw CLI::ValidationError
void requireProjectionOutput(const std::string& path, const std::string& option);

/// From pixel to pixel, along columns and rows of the first view's detector.
DetectorPair pitchOf(const ProjectionGeometry& geometry);

/// Warns of what is possible, but hardly meant.
void commentOnScan(const ScanArguments& arguments, const CommonOptions& common);

/// World position of the middle of the box around a volume's active voxels.
Vec3 middleOf(const openvdb::FloatGrid& volume);

/// The geometry that was asked for; unless told otherwise, the axis passes `center`. `measured` gives what the user
/// left out; null where nothing has been measured yet.
/// @throw CLI::ValidationError if something is missing. @throw Error as readGeometry and circularGeometry.
ProjectionGeometry scanGeometry(const ScanArguments& arguments, const MeasuredScan* measured, const Vec3& center);

}  // namespace raysweep::apps
