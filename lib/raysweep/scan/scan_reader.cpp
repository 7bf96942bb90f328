#include "raysweep/scan/scan_reader.h"

#include "raysweep/core/brief.h"
#include "raysweep/core/error.h"
#include "raysweep/scan/value_checks.h"
#include "raysweep/scan/view_angles.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

namespace raysweep {
namespace {

std::optional<double> numberIn(const std::string& text) {
    double number = 0;
    const char* const end = text.data() + text.size();
    const auto [next, failed] = std::from_chars(text.data(), end, number);
    if (failed != std::errc() || next != end) return {};
    return number;
}

FrameSource sourceOf(const std::string& text, FrameSource otherwise) {
    if (text.empty()) return otherwise;
    if (text == "none") return FrameSource::none;
    if (text == "auto") return FrameSource::sides;
    return numberIn(text) ? FrameSource::number : FrameSource::file;
}

bool isHdf5Scan(const ScanOptions& options) {
    return isHdf5(options.projections.front());
}

/// The mean of all frames, for each pixel: of those in which it was measured, NaN without any.
std::vector<float> meanFrame(const Projections& frames) {
    std::vector<float> mean(frames.pixelsPerView());
    for (std::size_t i = 0; i < mean.size(); ++i) {
        double sum = 0;
        int measured = 0;
        for (int n = 0; n < frames.views; ++n) {
            const float value = frames.view(n)[i];
            if (std::isnan(value)) continue;
            sum += value;
            ++measured;
        }
        mean[i] = float(sum / measured);
    }
    return mean;
}

/// The mean of the frames in a file, which must be as large as the projections, or as the whole detector whose rows
/// `rows` these are.
std::vector<float> readFrame(const std::string& path, const char* name, const ScanOptions& options,
                             const Projections& projections) {
    const Projections frames = readProjections({path}, {options.repair, options.unsignedCounts}).projections;
    const auto sizeOf = [](const Projections& p) { return std::to_string(p.width) + "x" + std::to_string(p.height); };
    std::vector<float> mean = meanFrame(frames);
    const auto width = std::ptrdiff_t(frames.width);
    if (options.rows && frames.width == projections.width && frames.height > options.rows->last) {
        mean.erase(mean.begin() + width * (options.rows->last + 1), mean.end());
        mean.erase(mean.begin(), mean.begin() + width * options.rows->first);
    } else if (frames.width != projections.width || frames.height != projections.height) {
        throw InvalidArgument("the " + std::string(name) + " frame has " + sizeOf(frames) + " pixels ('" + path +
                              "'), but the projections have " + sizeOf(projections) +
                              "; give frames that the same detector made");
    }
    return mean;
}

MeasuredFiles readHdf5(const ScanOptions& options, const ProgressCallback& progress) {
    DataExchangeOptions wanted;
    wanted.rows = options.rows;
    wanted.unsignedCounts = options.unsignedCounts;
    wanted.flat = flatSource(options) == FrameSource::own;
    wanted.dark = darkSource(options) == FrameSource::own;
    wanted.angles = options.geometry.file.empty() && options.geometry.angles.empty() && !options.geometry.arc;
    DataExchange file = readDataExchange(options.projections.front(), wanted, progress);
    MeasuredFiles measured;
    measured.format = "Data Exchange";
    measured.complete = file.complete;
    if (!file.complete) return measured;
    requireMeasured(file.counts, options.projections.front(), options.repair);
    measured.values = std::move(file.counts);
    measured.type = file.type;
    measured.flat = std::move(file.flat);
    measured.dark = std::move(file.dark);
    if (!file.angles.empty()) {
        ViewAngles angles = viewAngles(std::move(file.angles), file.angleUnits, options.geometry.angleUnit);
        if (!angles.said.empty()) measured.assumptions.push_back(angles.said);
        measured.scan.angles = std::move(angles.degrees);
    }
    if (file.sinograms)
        measured.assumptions.push_back("the file is ordered by detector row, view, column, as sinograms are");
    return measured;
}

/// Whether the rows of pictures are views. @param angles how many there are; 0: nobody says
bool areSinograms(const ScanOptions& options, const ProjectionFile& file, std::size_t angles) {
    if (options.sinograms != Sinograms::automatic) return options.sinograms == Sinograms::always;
    const Projections& p = file.projections;
    if (!options.geometry.file.empty() || options.geometry.width > 0 || p.height == 1) return false;
    const int said = options.geometry.views > 0 ? options.geometry.views : int(angles);
    if (said > 0) return said != p.views && said == p.height;
    return p.views == 1;  // a single view is no scan
}

/// @param said angles that `options.geometry.angles` names, in whatever unit
MeasuredFiles readFiles(const ScanOptions& options, const std::vector<double>& said, const ProgressCallback& progress) {
    ProjectionFile file = readProjections(options.projections, {options.repair, options.unsignedCounts}, progress);
    MeasuredFiles measured;
    measured.format = file.format;
    measured.complete = file.complete;
    if (!file.complete) return measured;
    if (areSinograms(options, file, said.size())) {
        const Projections& p = file.projections;
        measured.assumptions.push_back(
            (p.views == 1 ? "the picture is taken for a sinogram, of " : "the pictures are taken for sinograms, of ") +
            std::to_string(p.width) + " detector columns in " + std::to_string(p.height) + " views" +
            (options.sinograms == Sinograms::always ? "" : "; if it is one view, say with `views` that there is 1"));
        file = fromSinograms(file);
    }
    measured.values = std::move(file.projections);
    measured.type = file.type;
    measured.scan.spacing = file.spacing;
    measured.scan.origin = file.origin;
    return measured;
}

void requireAngles(const std::vector<double>& angles, const ScanOptions& options, const Projections& projections) {
    if (angles.size() == std::size_t(projections.views)) return;
    const bool turned = angles.size() == std::size_t(projections.width) && projections.height == 1;
    throw InvalidArgument("'" + options.geometry.angles + "' has " + std::to_string(angles.size()) +
                          " angles, but the projections have " + std::to_string(projections.views) + " views" +
                          (turned ? ", and as many columns: turn the sinogram, so that its rows are views"
                                  : "; give one angle for each view"));
}

void readFrames(const ScanOptions& options, MeasuredFiles& measured) {
    const FrameSource flat = flatSource(options), dark = darkSource(options);
    const std::size_t pixels = measured.values.pixelsPerView();
    if (flat == FrameSource::none) {
        measured.flat.clear();
        measured.dark.clear();
        return;
    }
    if (flat == FrameSource::file) measured.flat = readFrame(options.flat, "flat", options, measured.values);
    if (flat == FrameSource::number) measured.flat.assign(pixels, float(*numberIn(options.flat)));
    if (flat == FrameSource::sides) {
        measured.flat = flatFromSides(measured.values);
        measured.assumptions.push_back("without object " + brief(measured.flat[pixels / 2], 5) +
                                       " is counted (in the middle), as at the detector's sides");
    }
    if (dark == FrameSource::file) measured.dark = readFrame(options.dark, "dark", options, measured.values);
    if (dark == FrameSource::number) measured.dark.assign(pixels, float(*numberIn(options.dark)));
    if (!measured.dark.empty()) return;
    measured.dark.assign(pixels, 0.0f);
    measured.assumptions.push_back("without beam 0 is counted, as there are no frames of it");
}

}  // namespace

FrameSource flatSource(const ScanOptions& options) {
    return sourceOf(options.flat, isHdf5Scan(options) ? FrameSource::own : FrameSource::none);
}

FrameSource darkSource(const ScanOptions& options) {
    return sourceOf(options.dark, isHdf5Scan(options) ? FrameSource::own : FrameSource::none);
}

MeasuredFiles readMeasuredFiles(const ScanOptions& options, const ProgressCallback& progress) {
    std::vector<double> said;  // read once: what is no regular file can be read no second time
    if (!options.geometry.angles.empty()) said = readAngleFile(options.geometry.angles);
    MeasuredFiles measured = isHdf5Scan(options) ? readHdf5(options, progress) : readFiles(options, said, progress);
    if (!measured.complete) return measured;
    readFrames(options, measured);
    measured.scan.width = measured.values.width;
    measured.scan.height = measured.values.height;
    measured.scan.views = measured.values.views;
    if (!options.geometry.angles.empty()) {
        ViewAngles angles = viewAngles(std::move(said), "", options.geometry.angleUnit);
        if (!angles.said.empty()) measured.assumptions.push_back(angles.said);
        requireAngles(angles.degrees, options, measured.values);
        measured.scan.angles = std::move(angles.degrees);
    }
    return measured;
}

}  // namespace raysweep
