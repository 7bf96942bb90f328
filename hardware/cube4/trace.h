/// Where each stage's partial beam is, cycle by cycle.
#pragma once

#include "cube4/words.h"

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace raysweep::cube4 {

struct TraceEntry {
    int slice = -1, row = 0, part = 0;  ///< slice -1: a bubble
};

struct Trace {
    std::size_t most = 0;                         ///< cycles to record
    std::vector<std::string> stages;              ///< names, in the order of the flow
    std::vector<std::vector<TraceEntry>> cycles;  ///< of each stage
};

/// Adds a cycle, unless there are enough.
template <class Weight>
void recordTrace(Trace& trace, const std::vector<std::pair<const char*, const Beam<Weight>*>>& stages) {
    if (trace.cycles.size() >= trace.most) return;
    trace.stages.clear();
    std::vector<TraceEntry> entries;
    for (const auto& [name, beam] : stages) {
        trace.stages.push_back(name);
        entries.push_back(*beam ? TraceEntry{beam->slice->number, beam->row, beam->part} : TraceEntry{});
    }
    trace.cycles.push_back(std::move(entries));
}

}  // namespace raysweep::cube4
