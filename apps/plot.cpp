#include "plot.h"

#include "cli.h"

#include "raysweep/core/error.h"
#include "raysweep/core/output_file.h"

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

/// Inline data for gnuplot; logarithmic axes have no place for zero.
std::string dataBlock(const char* name, const std::vector<ConvergencePoint>& history, double ConvergencePoint::*value) {
    std::ostringstream block;
    block << "$" << name << " << EOD\n";
    for (const ConvergencePoint& point : history)
        if (point.*value > 0) block << point.sweep << ' ' << point.*value << '\n';
    block << "EOD\n";
    return block.str();
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

void plotConvergence(const std::string& path, const std::vector<ConvergencePoint>& history, double tolerance) {
    if (history.empty()) return;
    OutputFile file(path);
    const bool svg = std::filesystem::path(path).extension() == ".svg";
    std::ostringstream script;
    script << "set terminal " << (svg ? "svg size 800,500 background 'white'" : "pngcairo size 800,500") << "\n"
           << "set output " << quoted(file.temporary()) << "\n"
           << "set xlabel 'sweeps'\nset ylabel 'relative to the answer'\n"
           << "set logscale y\nset format y '%g'\nset grid\nset key top right\n"
           << dataBlock("rms", history, &ConvergencePoint::rms)
           << dataBlock("unshot", history, &ConvergencePoint::unshotShare)
           << "plot $rms with linespoints pt 7 ps 0.4 lw 2 title 'RMS difference of radiosity, 20 sweeps apart', "
           << "$unshot with lines lw 2 title 'unshot power / power injected'";
    if (tolerance > 0) script << ", " << tolerance << " with lines dt 2 lc 'black' title 'tolerance'";
    script << "\n";
    runGnuplot(script.str(), path);
    file.commit();
}

}  // namespace raysweep::apps
