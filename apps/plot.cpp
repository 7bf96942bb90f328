#include "plot.h"

#include "cli.h"

#include "raysweep/core/error.h"
#include "raysweep/core/output_file.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <sstream>

namespace raysweep::apps {
namespace {

std::string quoted(const std::string& text) {
    std::string result = "'";
    for (const char c : text) result += c == '\'' ? std::string("''") : std::string(1, c);
    return result + "'";
}

/// Inline data for gnuplot.
std::string dataBlock(std::size_t number, const Curve& curve) {
    std::ostringstream block;
    block << "$curve" << number << " << EOD\n";
    for (const auto& [x, y] : curve.points)
        if (y > 0) block << x << ' ' << y << '\n';
    block << "EOD\n";
    return block.str();
}

bool hasPoints(const Curve& curve) {
    return std::any_of(curve.points.begin(), curve.points.end(), [](const auto& point) { return point.second > 0; });
}

void runGnuplot(const std::string& script, const std::string& path) {
    std::FILE* gnuplot = ::popen("gnuplot", "w");
    const bool sent = gnuplot && std::fwrite(script.data(), 1, script.size(), gnuplot) == script.size();
    const int status = gnuplot ? ::pclose(gnuplot) : -1;
    if (!sent || status != 0) throw IoError("gnuplot could not draw '" + path + "'");
}

}  // namespace

void requirePlot(const std::string& path) {
    const std::string extension = std::filesystem::path(path).extension().string();
    if (extension != ".svg" && extension != ".png") usageError("--plot", "'" + path + "' must end in .svg or .png");
    requireWritable(path);
    if (std::system("command -v gnuplot >/dev/null 2>&1") != 0)
        throw IoError("--plot needs the program gnuplot: install it (Debian: apt-get install gnuplot-nox)");
}

void plotCurves(const std::string& path, const PlotLabels& labels, const std::vector<Curve>& curves) {
    OutputFile file(path);
    const bool svg = std::filesystem::path(path).extension() == ".svg";
    std::ostringstream data, lines;
    for (std::size_t n = 0; n < curves.size(); ++n) {
        if (!hasPoints(curves[n])) continue;
        data << dataBlock(n, curves[n]);
        lines << (lines.str().empty() ? "plot " : ", ") << "$curve" << n << " with "
              << (curves[n].isLimit ? "lines dt 2 lc 'black'" : "linespoints pt 7 ps 0.4 lw 2") << " title "
              << quoted(curves[n].title);
    }
    if (lines.str().empty()) return;
    std::ostringstream script;
    script << "set terminal " << (svg ? "svg size 800,500 background 'white'" : "pngcairo size 800,500") << "\n"
           << "set output " << quoted(file.temporary()) << "\n"
           << "set xlabel " << quoted(labels.x) << "\nset ylabel " << quoted(labels.y) << "\n"
           << "set logscale y\nset format y '%g'\nset grid\nset key top right\n"
           << data.str() << lines.str() << "\n";
    runGnuplot(script.str(), path);
    file.commit();
}

}  // namespace raysweep::apps
