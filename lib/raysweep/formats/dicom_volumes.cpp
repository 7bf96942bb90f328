#include "raysweep/formats/dicom_volumes.h"

#include "raysweep/core/error.h"
#include "raysweep/core/natural_order.h"
#include "raysweep/formats/header_lines.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

namespace raysweep {
namespace {

std::string number(double value) {
    std::ostringstream text;
    text << value;
    return text.str();
}

/// For messages.
std::string nameOf(const DicomFrame& frame) {
    return "'" + frame.file + "'" + (frame.index > 0 ? ", frame " + std::to_string(frame.index) + "," : "");
}

Vec3 normalOf(const std::vector<double>& axes) {
    return Vec3(axes[0], axes[1], axes[2]).cross(Vec3(axes[3], axes[4], axes[5]));
}

/// Frames that are in one place, each place in a list of its own.
using Places = std::vector<std::vector<const DicomFrame*>>;

Places placesOf(const std::vector<DicomFrame>& frames) {
    constexpr double kSamePlace = 0.01;  // mm; slices are further apart, and one place is written in the same way
    Places places;
    for (const DicomFrame& frame : frames) {
        if (places.empty() || (places.back().front()->position - frame.position).length() > kSamePlace)
            places.emplace_back();
        places.back().push_back(&frame);
    }
    return places;
}

/// What a frame says of some of its traits, the key by which volumes are told apart.
std::string valueOf(const DicomFrame& frame, const std::vector<std::string>& traits) {
    std::string value;
    for (const std::string& trait : traits)
        value += (value.empty() ? "" : ", ") + trait + " " + frame.traits->at(trait);
    return value;
}

/// The values of `traits`, one per volume; empty if they do not tell the frames of each place apart, in the same way.
std::vector<std::string> valuesOf(const Places& places, const std::vector<std::string>& traits) {
    std::set<std::string> first;
    for (const auto& place : places) {
        std::set<std::string> values;
        for (const DicomFrame* const frame : place) values.insert(valueOf(*frame, traits));
        if (values.size() != place.size()) return {};
        if (first.empty()) first = values;
        if (values != first) return {};
    }
    std::vector<std::string> sorted(first.begin(), first.end());
    std::sort(sorted.begin(), sorted.end(), naturallyBefore);
    return sorted;
}

/// The traits that tell volumes apart: one if one does, else all that differ at all; empty if none do.
std::vector<std::string> tellingTraits(const Places& places) {
    std::vector<std::string> differing;
    for (const auto& trait : *places.front().front()->traits) {
        if (!valuesOf(places, {trait.first}).empty()) return {trait.first};
        std::set<std::string> values;
        for (const DicomFrame* const frame : places.front()) values.insert(frame->traits->at(trait.first));
        if (values.size() > 1) differing.push_back(trait.first);
    }
    // Times of acquisition differ from slice to slice.
    differing.erase(std::remove(differing.begin(), differing.end(), "acquisition time"), differing.end());
    return valuesOf(places, differing).empty() ? std::vector<std::string>() : differing;
}

}  // namespace

void sortByNumber(std::vector<DicomFrame>& frames) {
    std::sort(frames.begin(), frames.end(), [](const DicomFrame& a, const DicomFrame& b) {
        if (a.number != b.number) return a.number < b.number;
        return a.file != b.file ? naturallyBefore(a.file, b.file) : a.index < b.index;
    });
}

void sortByPosition(std::vector<DicomFrame>& frames) {
    sortByNumber(frames);  // so that the messages below do not depend on the order of the files
    const DicomFrame& first = frames.front();
    for (const DicomFrame& frame : frames) {
        if (frame.axes.empty())
            throw InvalidArgument(nameOf(frame) + " does not say where it is", Remedy::spaceSlicesByNumber);
        for (std::size_t n = 0; n < 6; ++n)
            if (!(std::abs(frame.axes[n] - first.axes[n]) < 1e-3))
                throw InvalidArgument(nameOf(frame) + " and " + nameOf(first) +
                                      " are turned against each other: these images are no volume");
    }
    const Vec3 normal = normalOf(first.axes);
    std::stable_sort(frames.begin(), frames.end(), [&](const DicomFrame& a, const DicomFrame& b) {
        return a.position.dot(normal) < b.position.dot(normal);
    });
}

std::vector<DicomFrame> chooseFrames(std::vector<DicomFrame> frames, const VolumeChoice& choice) {
    const Places places = placesOf(frames);
    const std::size_t volumes = places.front().size();
    const bool even = std::all_of(places.begin(), places.end(), [&](const auto& p) { return p.size() == volumes; });
    Several several{even ? volumes : 1, "volumes of " + std::to_string(places.size()) + " slices each", {}};
    const std::vector<std::string> traits = even && volumes > 1 ? tellingTraits(places) : std::vector<std::string>();
    const std::vector<std::string> values = traits.empty() ? traits : valuesOf(places, traits);
    if (!values.empty())
        several.name = [&](int n) { return "(" + values[std::size_t(n)] + ")"; };
    else
        several.what += " (told apart by the order of their numbers alone)";
    const auto chosen = std::size_t(chooseVolume(frames.front().file, several, choice));
    if (several.count == 1) return frames;
    std::vector<DicomFrame> slices;
    for (const auto& place : places) {
        if (values.empty()) slices.push_back(*place[chosen]);
        for (const DicomFrame* const frame : place)
            if (!values.empty() && valueOf(*frame, traits) == values[chosen]) slices.push_back(*frame);
    }
    return slices;
}

Vec3 stepOf(const std::vector<DicomFrame>& slices) {
    const auto last = slices.size() - 1;
    const Vec3 step = (slices[last].position - slices[0].position) / double(last);
    for (std::size_t n = 0; n <= last; ++n) {
        const double off = (slices[n].position - slices[0].position - step * double(n)).length();
        if (off < 0.1 * step.length()) continue;
        std::vector<double> gaps;
        for (std::size_t k = 0; k < last; ++k) gaps.push_back((slices[k + 1].position - slices[k].position).length());
        std::vector<double> sorted = gaps;
        std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(last / 2), sorted.end());
        const double usual = sorted[last / 2];
        const auto odd = std::max_element(
            gaps.begin(), gaps.end(), [&](double a, double b) { return std::abs(a - usual) < std::abs(b - usual); });
        const auto at = std::size_t(odd - gaps.begin());
        throw InvalidArgument("the slices are not equally spaced: " + number(*odd) + " mm from " + nameOf(slices[at]) +
                                  " to " + nameOf(slices[at + 1]) + ", " + number(usual) +
                                  " mm elsewhere; is one missing, or are there two volumes?",
                              Remedy::spaceSlicesEvenly);
    }
    return step;
}

}  // namespace raysweep
