/// How an object was, or is to be, X-rayed: what `raysweep project`, `generate` and `ct` share.
#pragma once

#include "cli.h"

#include "raysweep/scan/scan_geometry.h"

#include <optional>
#include <string>

namespace raysweep::apps {

/// What the user typed; empty text: not given.
struct ScanArguments {
    ScanGeometryOptions options;  ///< whole after completeScanOptions
    std::string cone, detector, pitch, center, angleUnit;
    bool parallel = false;
};

void addScanOptions(CLI::App& app, ScanArguments& arguments);

/// Reads what was typed into `options`, and checks what can be checked without a file. @throw CLI::ValidationError
void completeScanOptions(ScanArguments& arguments);

/// Where nothing has been measured yet: that the number of views and the detector are given. @throw
/// CLI::ValidationError
void requireWhole(const ScanArguments& arguments);

/// The same, and unless told otherwise the axis passes `center`.
ScanGeometryOptions centeredAt(const Vec3& center, ScanGeometryOptions options);

/// Projections are written as `.mha` or numbered `.exr`. @throw CLI::ValidationError
/// The files that projections are written to, as far as that is known before a geometry file is read.
std::vector<std::string> projectionNames(const std::string& path, const ScanArguments& arguments);

void requireProjectionOutput(const std::string& path, const std::string& option);

}  // namespace raysweep::apps
