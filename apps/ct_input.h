/// From files of a scan to line integrals and where their rays ran.
#pragma once

#include "scan_options.h"

#include "raysweep/camera/projections.h"

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <string>
#include <vector>

namespace raysweep::apps {

/// What the user typed; empty text: not given.
struct CtInputArguments {
    std::vector<std::string> files;
    ScanArguments scan;
    std::string axisColumn, flat, dark, rows;
    std::optional<double> saturation, scale;
    int ringWindow = 0;  ///< 0: no filter
    bool deadPixels = false, repair = false;
};

void addCtInputOptions(CLI::App& app, CtInputArguments& arguments);

/// Checks what can be checked without the files, and fills in what follows. @throw CLI::ValidationError
void completeOptions(CtInputArguments& arguments);

struct CtInput {
    Projections projections;  ///< line integrals; NaN where not measured
    ProjectionGeometry geometry;
    nlohmann::ordered_json report() const;

    std::string format;
    std::size_t deadPixels = 0, saturated = 0, notMeasured = 0;
    std::optional<double> axisColumn;  ///< where it was looked for: where it was found
    double axisMismatch = 0;
    bool complete = true;  ///< false if the user stopped it
};

/// @param center where the axis is unless the user says so
CtInput readCtInput(const CtInputArguments& arguments, const CommonOptions& common, const Vec3& center,
                    const ProgressCallback& progress);

}  // namespace raysweep::apps
