#include "trace_picture.h"

#include "raysweep/core/text_file.h"

#include <algorithm>
#include <iomanip>
#include <sstream>

namespace raysweep::apps {
namespace {

std::string nameOf(const cube4::TraceEntry& entry) {
    if (entry.slice < 0) return ".";
    return std::to_string(entry.slice) + "." + std::to_string(entry.row) + "." + std::to_string(entry.part);
}

}  // namespace

std::string traceTable(const cube4::Trace& trace) {
    constexpr int kLeast = 9;
    std::ostringstream table;
    table << std::setw(6) << "cycle";
    std::vector<int> widths;
    for (const std::string& stage : trace.stages) {
        widths.push_back(std::max(kLeast, int(stage.size())) + 1);
        table << std::setw(widths.back()) << stage;
    }
    table << "\n";
    for (std::size_t cycle = 0; cycle < trace.cycles.size(); ++cycle) {
        table << std::setw(6) << cycle;
        for (std::size_t stage = 0; stage < trace.stages.size(); ++stage)
            table << std::setw(widths[stage]) << nameOf(trace.cycles[cycle][stage]);
        table << "\n";
    }
    return table.str();
}

void drawTrace(const std::string& path, const cube4::Trace& trace) {
    constexpr int kWidth = 92, kHeight = 20, kLeft = 50, kTop = 30;
    const int columns = int(trace.stages.size()), lines = int(trace.cycles.size());
    std::ostringstream svg;
    svg << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << kLeft + kWidth * columns << "\" height=\""
        << kTop + kHeight * lines << "\" font-family=\"sans-serif\" font-size=\"11\">\n"
        << "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
    const auto text = [&](int x, int y, const std::string& what) {
        svg << "<text x=\"" << x << "\" y=\"" << y << "\" text-anchor=\"middle\">" << what << "</text>\n";
    };
    for (int stage = 0; stage < columns; ++stage)
        text(kLeft + kWidth * stage + kWidth / 2, kTop - 10, trace.stages[std::size_t(stage)]);
    for (int cycle = 0; cycle < lines; ++cycle) {
        const int y = kTop + kHeight * cycle;
        text(kLeft / 2, y + 14, std::to_string(cycle));
        for (int stage = 0; stage < columns; ++stage) {
            const cube4::TraceEntry& entry = trace.cycles[std::size_t(cycle)][std::size_t(stage)];
            const int x = kLeft + kWidth * stage, hue = (entry.slice * 97 + entry.row * 47 + entry.part * 13) % 360;
            svg << "<rect x=\"" << x << "\" y=\"" << y << "\" width=\"" << kWidth - 2 << "\" height=\"" << kHeight - 2
                << "\" fill=\"";
            if (entry.slice < 0)
                svg << "#f0f0f0\"/>\n";
            else
                svg << "hsl(" << hue << ",60%,80%)\"/>\n";
            if (entry.slice >= 0) text(x + kWidth / 2, y + 14, nameOf(entry));
        }
    }
    svg << "</svg>\n";
    writeText(path, svg.str());
}

}  // namespace raysweep::apps
