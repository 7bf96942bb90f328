/// Pictures of how a computation went.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace raysweep::apps {

/// Fails early: the file must end in .svg or .png and gnuplot must be there. @throw Error
void requirePlot(const std::string& path);

/// A line through points (x, y); points with y = 0 or less, or NaN, are left out, since the axis is logarithmic.
struct Curve {
    std::string title;
    std::vector<std::pair<double, double>> points;
    bool isLimit = false;  ///< drawn dashed
};

struct PlotLabels {
    std::string x, y;
};

/// Draws curves over a linear x and a logarithmic y, as .svg or .png; nothing if there is no point.
/// @throw IoError if gnuplot fails or the file cannot be written
void plotCurves(const std::string& path, const PlotLabels& labels, const std::vector<Curve>& curves);

}  // namespace raysweep::apps
