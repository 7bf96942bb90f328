#include "raysweep/scan/data_exchange.h"

#include "raysweep/core/error.h"
#include "raysweep/core/file_name.h"
#include "raysweep/core/memory.h"
#include "raysweep/scan/count_type.h"
#include "raysweep/scan/hdf5_dataset.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raysweep {
namespace {

/// Numbers that HDF5 reads at once, so that reading can be stopped, and frames need not all be held: 64 MB.
constexpr std::uint64_t kPiece = std::uint64_t(1) << 24;

/// How a dataset holds frames of rows of columns: one frame after the other, or (sinograms) one row of all frames after
/// the other. Two dimensions lack `missing` of the three: 0 means one frame, 1 frames of one row.
struct Frames {
    const Hdf5Dataset& set;
    bool sinograms = false;
    std::size_t missing = 0;

    bool isWhole() const { return set.sizes().size() == 3; }
    /// frames, rows, columns
    Hdf5Extent sizes() const {
        Hdf5Extent sizes = set.sizes();
        if (!isWhole()) sizes.insert(sizes.begin() + std::ptrdiff_t(std::min(missing, sizes.size())), 1);
        if (sinograms && isWhole()) std::swap(sizes[0], sizes[1]);
        return sizes;
    }
};

/// Calls `use(first frame, frames, numbers)` for all frames, some at a time, with `rows` of each; numbers are ordered
/// by frame, row, column.
template <class Use>
void readFrames(const Frames& from, const RowRange& rows, const Use& use) {
    const Hdf5Extent sizes = from.sizes();
    const std::uint64_t height = std::uint64_t(rows.last - rows.first + 1), width = sizes[2];
    const std::uint64_t step = std::max<std::uint64_t>(1, kPiece / (height * width));
    std::vector<float> piece, turned;
    for (std::uint64_t first = 0; first < sizes[0]; first += step) {
        const std::uint64_t count = std::min(step, sizes[0] - first);
        Hdf5Extent start = {first, std::uint64_t(rows.first), 0}, box = {count, height, width};
        const bool turn = from.sinograms && from.isWhole();
        if (turn) std::swap(start[0], start[1]), std::swap(box[0], box[1]);
        if (!from.isWhole()) {
            start.erase(start.begin() + std::ptrdiff_t(from.missing));
            box.erase(box.begin() + std::ptrdiff_t(from.missing));
        }
        piece.resize(std::size_t(count * height * width));
        from.set.read(start, box, piece.data());
        if (turn) {
            turned.resize(piece.size());
            for (std::uint64_t y = 0; y < height; ++y)
                for (std::uint64_t n = 0; n < count; ++n)
                    std::copy_n(piece.begin() + std::ptrdiff_t((y * count + n) * width), width,
                                turned.begin() + std::ptrdiff_t((n * height + y) * width));
            piece.swap(turned);
        }
        if (!use(std::size_t(first), std::size_t(count), piece)) return;
    }
}

/// As readFrames, with counts that are what was counted.
template <class Use>
void readCounts(const Frames& from, const RowRange& rows, const DataExchangeOptions& options, const std::string& what,
                const Use& use) {
    const SampleType type = from.set.type();
    readFrames(from, rows, [&](std::size_t first, std::size_t count, std::vector<float>& piece) {
        if (options.unsignedCounts) {
            addWrapped(piece.data(), piece.size(), type);
        } else {
            float least = 0;
            for (const float value : piece) least = std::min(least, value);
            requireCounts(least, type, what);
        }
        return use(first, count, piece);
    });
}

/// The datasets of a scan, and how they are ordered.
struct Layout {
    const Hdf5File& file;
    Hdf5Dataset data;
    std::optional<Hdf5Dataset> white, dark, theta;
    bool sinograms = false;

    std::string pathOf(const char* name) const { return "'" + file.path() + "', /exchange/" + name; }
    Frames views(bool sinograms) const { return {data, sinograms, 1}; }
};

/// How `set` holds frames of the rows and columns of `view`; nothing if it does not. @param sinograms the views are
std::optional<Frames> framesOf(const Hdf5Dataset& set, const Hdf5Extent& view, bool sinograms) {
    for (const Frames& frames : {Frames{set, false, 0}, Frames{set, false, 1}, Frames{set, sinograms, 0}}) {
        const Hdf5Extent sizes = frames.sizes();
        if (sizes.size() == 3 && sizes[1] == view[1] && sizes[2] == view[2]) return frames;
    }
    return {};
}

/// What the attribute says, else the only order that angles and frames fit, else views.
bool areSinograms(const Layout& layout) {
    if (layout.data.sizes().size() != 3) return false;
    const std::string axes = layout.data.attribute("axes");
    if (axes.rfind("theta", 0) == 0) return false;
    if (axes.rfind("y:theta", 0) == 0) return true;
    const auto isFine = [&](bool sinograms) {
        const Hdf5Extent sizes = layout.views(sinograms).sizes();
        if (layout.theta && layout.theta->sizes()[0] != sizes[0]) return false;
        for (const auto* frames : {&layout.white, &layout.dark})
            if (*frames && !framesOf(**frames, sizes, sinograms)) return false;
        return true;
    };
    return !isFine(false) && isFine(true);
}

/// Mean over the frames of `set`, whose frames must be as large as the views of `data`: of the values that are finite.
std::vector<float> meanFrame(const Layout& layout, const Hdf5Dataset& set, const char* name, const RowRange& rows,
                             const DataExchangeOptions& options, int& frames) {
    const auto from = framesOf(set, layout.views(layout.sinograms).sizes(), layout.sinograms);
    if (!from)
        set.fail("its size is " + set.sizeText() + ", which does not fit that of /exchange/data, " +
                 layout.data.sizeText());
    std::vector<double> sums;
    std::vector<int> counted;
    readCounts(*from, rows, options, layout.pathOf(name),
               [&](std::size_t, std::size_t count, const std::vector<float>& piece) {
                   const std::size_t pixels = piece.size() / count;
                   sums.resize(pixels, 0.0);
                   counted.resize(pixels, 0);
                   for (std::size_t p = 0; p < piece.size(); ++p) {
                       if (!std::isfinite(piece[p])) continue;
                       sums[p % pixels] += piece[p];
                       ++counted[p % pixels];
                   }
                   return true;
               });
    frames = int(from->sizes()[0]);
    std::vector<float> mean(sums.size());
    for (std::size_t p = 0; p < mean.size(); ++p)
        mean[p] = counted[p] > 0 ? float(sums[p] / counted[p]) : std::numeric_limits<float>::quiet_NaN();
    return mean;
}

std::vector<double> readAngles(const Hdf5Dataset& set, std::uint64_t views) {
    if (set.sizes().size() != 1) set.fail("its size is " + set.sizeText() + ", but it must be one angle for each view");
    if (set.sizes()[0] != views)
        set.fail("it has " + set.sizeText() + " angles, but /exchange/data has " + std::to_string(views) +
                 " views; give the right ones as `angles`, or an `arc`");
    std::vector<double> angles(std::size_t(set.sizes()[0]));
    set.read({0}, set.sizes(), angles.data());
    for (const double angle : angles)
        if (!std::isfinite(angle)) set.fail("an angle is not finite; give the right ones as `angles`, or an `arc`");
    return angles;
}

RowRange requireRows(const std::optional<RowRange>& rows, int height, const std::string& path) {
    const RowRange all{0, height - 1}, chosen = rows.value_or(all);
    if (chosen.first < 0 || chosen.last < chosen.first || chosen.last >= height)
        throw InvalidArgument("rows " + std::to_string(chosen.first) + " to " + std::to_string(chosen.last) +
                              " are not in '" + path + "': it has rows 0 to " + std::to_string(height - 1));
    return chosen;
}

/// @throw IoError saying what is there instead of the Data Exchange layout.
void requireExchange(const Hdf5File& file) {
    if (file.has("exchange")) return;
    std::string there;
    for (const std::string& name : file.names()) there += (there.empty() ? "" : ", ") + ("/" + name);
    throw IoError("cannot read '" + file.path() + "': it has no group /exchange, so it is not of the Data Exchange " +
                  "layout (/exchange/data, data_white, data_dark, theta), but has " +
                  (there.empty() ? "nothing" : there) +
                  "; convert it (dxchange reads the layouts of ALS, ESRF, Elettra and others, and nxtomo those of " +
                  "NeXus), or give the projections as MetaImage or pictures");
}

std::optional<Hdf5Dataset> openIf(const Hdf5File& file, bool wanted, std::initializer_list<const char*> names) {
    for (const char* name : names)
        if (wanted && file.has(name)) return std::optional<Hdf5Dataset>(std::in_place, file, name);
    return {};
}

}  // namespace

bool isHdf5(const std::string& path) {
    const std::string extension = lowerExtension(path);
    return extension == ".h5" || extension == ".hdf5" || extension == ".hdf" || extension == ".nxs";
}

DataExchange readDataExchange(const std::string& path, const DataExchangeOptions& options,
                              const ProgressCallback& progress) {
    const Hdf5File file(path);
    requireExchange(file);
    if (!file.has("exchange/data")) throw IoError("cannot read '" + path + "': there is no dataset /exchange/data");
    if (options.flat && !file.has("exchange/data_white") && !file.has("exchange/data_flat"))
        throw IoError("cannot read '" + path + "': there is no dataset /exchange/data_white, what is counted without " +
                      "object; say it as `flat`: a file, a number, auto (from the detector's sides), or none if the " +
                      "values are line integrals");
    Layout layout{file, Hdf5Dataset(file, "exchange/data"),
                  openIf(file, options.flat, {"exchange/data_white", "exchange/data_flat"}),
                  openIf(file, options.dark, {"exchange/data_dark"}), openIf(file, options.angles, {"exchange/theta"})};
    if (layout.data.sizes().size() < 2)
        layout.data.fail("its size is " + layout.data.sizeText() + ", but it must be views x rows x columns");
    layout.sinograms = areSinograms(layout);
    const Frames frames = layout.views(layout.sinograms);
    const Hdf5Extent sizes = frames.sizes();
    const RowRange range = requireRows(options.rows, int(sizes[1]), path);
    requireBytes(double(sizes[0]) * (range.last - range.first + 1) * double(sizes[2]) * sizeof(float),
                 "'" + path + "': its counts take", "read some of the `rows` only");

    DataExchange scan;
    scan.type = layout.data.type();
    scan.sinograms = layout.sinograms;
    scan.detectorRows = int(sizes[1]);
    if (layout.white) scan.flat = meanFrame(layout, *layout.white, "data_white", range, options, scan.flatFrames);
    if (layout.dark) scan.dark = meanFrame(layout, *layout.dark, "data_dark", range, options, scan.darkFrames);
    if (layout.theta) {
        scan.angles = readAngles(*layout.theta, sizes[0]);
        scan.angleUnits = layout.theta->attribute("units");
    }
    scan.counts = Projections(int(sizes[2]), range.last - range.first + 1, int(sizes[0]));
    readCounts(frames, range, options, layout.pathOf("data"),
               [&](std::size_t first, std::size_t count, const std::vector<float>& piece) {
                   std::copy(piece.begin(), piece.end(), scan.counts.view(int(first)));
                   scan.complete = report(progress, "reading", double(first + count) / scan.counts.views);
                   return scan.complete;
               });
    return scan;
}

}  // namespace raysweep
