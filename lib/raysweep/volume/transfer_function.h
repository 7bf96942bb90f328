/// Transfer functions: opacity, and if wanted colour, of a voxel as a function of its scalar value. They turn measured
/// values (CT numbers, simulation output) into a solid (docs/illumination.md, "Transfer functions").
#pragma once

#include "raysweep/core/types.h"

#include <string>
#include <vector>

namespace raysweep {

/// Larger opacities count as this, an optical depth of 9.2 per voxel edge: opacity 1 would be an infinite extinction.
constexpr double kMostOpaque = 0.9999;

/// Opacity of a ramp at its upper end where nothing else is said.
constexpr double kRampOpacity = 0.99;

struct TransferPoint {
    double value = 0;         ///< in the units of the classified grid, finite
    double opacity = 0;       ///< of light that crosses one voxel edge, 1, in [0,1]
    Color color = grey(0.f);  ///< single-scattering albedo per wavelength, linear, 1, in [0,1]; see `coloured`
};

/// Linear between its points, constant beyond the first and the last.
struct TransferFunction {
    std::vector<TransferPoint> points;  ///< ascending in value; of two points with one value, the later counts there,
                                        ///< which makes a step
    bool coloured = false;              ///< `color` is meant; else it says nothing, and albedo comes from elsewhere

    /// @throw InvalidArgument naming the point (the first has number 1), the field, its value and its bounds.
    void validate() const;
};

/// Opacity 0 at and below `low`, linear up to `opacity` at and above `high`.
/// @throw InvalidArgument unless low < high, both finite, and 0 < opacity <= 1.
TransferFunction rampFunction(double low, double high, double opacity = kRampOpacity);

/// Reads a table from a JSON file: a list of points {"value": v, "opacity": a, "color": [r, g, b]}, `color` in all of
/// them or in none.
/// @throw IoError if the file cannot be read, is not JSON, or is not such a list; it names file, point and bound.
TransferFunction readTransferFunction(const std::string& path);

/// The function as text that `readTransferFunction` understands, without line breaks.
std::string toJson(const TransferFunction& function);

/// What the function gives for one value. The colour has no meaning unless the function is `coloured`.
TransferPoint evaluate(const TransferFunction& function, double value);

/// Extinction, 1/world unit, that gives `opacity` (at most kMostOpaque) over a length of `edge` world units:
/// -ln(1 - opacity) / edge.
double extinctionFromOpacity(double opacity, double edge);

}  // namespace raysweep
