// The only place that sees HDF5.
#include "raysweep/scan/data_exchange.h"

#include "raysweep/core/error.h"
#include "raysweep/core/file_name.h"

#include <hdf5.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace fs = std::filesystem;

namespace raysweep {
namespace {

[[noreturn]] void fail(const std::string& path, const std::string& why) {
    throw IoError("cannot read '" + path + "': " + why);
}

/// While it lives, HDF5 keeps its errors instead of printing them.
class QuietHdf5 {
  public:
    QuietHdf5() {
        H5Eget_auto2(H5E_DEFAULT, &print_, &data_);
        H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    }
    ~QuietHdf5() { H5Eset_auto2(H5E_DEFAULT, print_, data_); }
    QuietHdf5(const QuietHdf5&) = delete;
    QuietHdf5& operator=(const QuietHdf5&) = delete;

    /// What the last call that failed says about the cause.
    static std::string reason() {
        std::string deepest;
        const auto keep = [](unsigned, const H5E_error2_t* error, void* to) -> herr_t {
            if (error->desc) *static_cast<std::string*>(to) = error->desc;
            return 0;
        };
        H5Ewalk2(H5E_DEFAULT, H5E_WALK_DOWNWARD, keep, &deepest);
        return deepest.empty() ? "HDF5 gives no reason" : deepest;
    }

  private:
    H5E_auto2_t print_ = nullptr;
    void* data_ = nullptr;
};

/// An identifier of HDF5, closed by the function that belongs to it.
class Handle {
  public:
    Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
    ~Handle() {
        if (id_ >= 0) close_(id_);
    }
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    operator hid_t() const { return id_; }

  private:
    hid_t id_;
    herr_t (*close_)(hid_t);
};

/// A dataset of numbers, open. `name` without the leading slash.
class Dataset {
  public:
    Dataset(hid_t file, const std::string& path, const std::string& name)
        : path_(path), name_(name), set_(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose) {
        if (set_ < 0) failHere("it cannot be opened (" + QuietHdf5::reason() + ")");
        const Handle type(H5Dget_type(set_), H5Tclose);
        const H5T_class_t kind = type < 0 ? H5T_NO_CLASS : H5Tget_class(type);
        if (kind != H5T_INTEGER && kind != H5T_FLOAT) failHere("it must hold numbers");
        const Handle space(H5Dget_space(set_), H5Sclose);
        const int rank = space < 0 ? -1 : H5Sget_simple_extent_ndims(space);
        if (rank < 1 || rank > 3) failHere("it has " + std::to_string(rank) + " dimensions");
        sizes_.resize(std::size_t(rank));
        H5Sget_simple_extent_dims(space, sizes_.data(), nullptr);
        for (const hsize_t size : sizes_)
            if (size < 1 || size > 0x7fffffff) failHere("its size is " + sizeText());
    }

    const std::vector<hsize_t>& sizes() const { return sizes_; }

    /// HDF5 makes up zeros for what was never written, of a scan that was interrupted, for instance.
    void requireWritten() const {
        const Handle creation(H5Dget_create_plist(set_), H5Pclose);
        const H5D_layout_t layout = H5Pget_layout(creation);
        bool written = true;
        if (layout == H5D_CHUNKED) {
            std::vector<hsize_t> chunk(sizes_.size());
            H5Pget_chunk(creation, int(chunk.size()), chunk.data());
            hsize_t chunks = 1, stored = 0;
            for (std::size_t axis = 0; axis < chunk.size(); ++axis)
                chunks *= (sizes_[axis] + chunk[axis] - 1) / std::max<hsize_t>(chunk[axis], 1);
            const Handle space(H5Dget_space(set_), H5Sclose);
            written = H5Dget_num_chunks(set_, space, &stored) < 0 || stored >= chunks;
        } else if (layout == H5D_CONTIGUOUS && H5Pget_external_count(creation) == 0) {
            written = H5Dget_storage_size(set_) > 0;
        }
        if (!written) failHere("parts of it were never written; was the scan interrupted?");
    }

    /// "181 x 2 x 640"
    std::string sizeText() const {
        std::string text;
        for (const hsize_t size : sizes_) text += (text.empty() ? "" : " x ") + std::to_string(size);
        return text;
    }

    void requireRank(std::size_t rank, const char* what) const {
        if (sizes_.size() != rank) failHere("its size is " + sizeText() + ", but it must be " + what);
    }

    /// Reads the box that starts at `start` and has `count` numbers along each dimension.
    void read(const std::vector<hsize_t>& start, const std::vector<hsize_t>& count, hid_t type, void* to) const {
        const Handle from(H5Dget_space(set_), H5Sclose);
        const Handle memory(H5Screate_simple(int(count.size()), count.data(), nullptr), H5Sclose);
        if (H5Sselect_hyperslab(from, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr) < 0 ||
            H5Dread(set_, type, memory, from, H5P_DEFAULT, to) < 0)
            failHere("it is damaged, or packed in a way that this build of HDF5 cannot unpack (" + QuietHdf5::reason() +
                     ")");
    }

    [[noreturn]] void failHere(const std::string& why) const { fail(path_, "/" + name_ + ": " + why); }

  private:
    std::string path_, name_;
    Handle set_;
    std::vector<hsize_t> sizes_;
};

bool has(hid_t file, const std::string& name) {
    return H5Lexists(file, name.c_str(), H5P_DEFAULT) > 0;
}

/// Numbers that HDF5 reads at once, so that reading can be stopped, and frames need not all be held: 64 MB.
constexpr hsize_t kPiece = hsize_t(1) << 24;

/// Calls `use(first frame, frames, numbers)` for all frames, some at a time, with `rows` of each.
template <class Use>
void readFrames(const Dataset& set, const RowRange& rows, const Use& use) {
    const hsize_t frames = set.sizes()[0], height = hsize_t(rows.last - rows.first + 1), width = set.sizes()[2];
    const hsize_t step = std::max<hsize_t>(1, kPiece / (height * width));
    std::vector<float> piece;
    for (hsize_t first = 0; first < frames; first += step) {
        const hsize_t count = std::min(step, frames - first);
        piece.resize(std::size_t(count * height * width));
        set.read({first, hsize_t(rows.first), 0}, {count, height, width}, H5T_NATIVE_FLOAT, piece.data());
        if (!use(std::size_t(first), std::size_t(count), piece)) return;
    }
}

/// Mean over the frames of `set`, whose frames must be as large as the views of `data`.
std::vector<float> meanFrame(const Dataset& set, const Dataset& data, const RowRange& rows, int& frames) {
    set.requireRank(3, "frames x rows x columns");
    if (set.sizes()[1] != data.sizes()[1] || set.sizes()[2] != data.sizes()[2])
        set.failHere("its size is " + set.sizeText() + ", which does not fit that of /exchange/data, " +
                     data.sizeText());
    std::vector<double> sums;
    readFrames(set, rows, [&](std::size_t, std::size_t count, const std::vector<float>& piece) {
        const std::size_t pixels = piece.size() / count;
        sums.resize(pixels, 0.0);
        for (std::size_t p = 0; p < piece.size(); ++p) sums[p % pixels] += piece[p];
        return true;
    });
    frames = int(set.sizes()[0]);
    std::vector<float> mean(sums.size());
    std::transform(sums.begin(), sums.end(), mean.begin(), [&](double sum) { return float(sum / frames); });
    return mean;
}

std::vector<double> readAngles(const Dataset& set, const Dataset& data) {
    set.requireRank(1, "one angle for each view");
    if (set.sizes()[0] != data.sizes()[0])
        set.failHere("it has " + set.sizeText() + " angles, but /exchange/data has " + std::to_string(data.sizes()[0]) +
                     " views");
    std::vector<double> angles(std::size_t(set.sizes()[0]));
    set.read({0}, {set.sizes()[0]}, H5T_NATIVE_DOUBLE, angles.data());
    for (const double angle : angles)
        if (!std::isfinite(angle)) set.failHere("an angle is not finite");
    return angles;
}

RowRange requireRows(const std::optional<RowRange>& rows, const Dataset& data, const std::string& path) {
    const int height = int(data.sizes()[1]);
    const RowRange all{0, height - 1}, chosen = rows.value_or(all);
    if (chosen.first < 0 || chosen.last < chosen.first || chosen.last >= height)
        throw InvalidArgument("rows " + std::to_string(chosen.first) + " to " + std::to_string(chosen.last) +
                              " are not in '" + path + "': it has rows 0 to " + std::to_string(height - 1));
    return chosen;
}

}  // namespace

bool isHdf5(const std::string& path) {
    const std::string extension = lowerExtension(path);
    return extension == ".h5" || extension == ".hdf5" || extension == ".hdf" || extension == ".nxs";
}

DataExchange readDataExchange(const std::string& path, const std::optional<RowRange>& rows,
                              const ProgressCallback& progress) {
    std::error_code ignored;
    if (!fs::exists(path, ignored)) fail(path, "there is no such file");
    if (fs::is_directory(path, ignored)) fail(path, "it is a folder; give an HDF5 file");
    const QuietHdf5 quiet;
    const Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
    if (file < 0) fail(path, "it is no HDF5 file, or damaged (" + QuietHdf5::reason() + ")");
    if (!has(file, "exchange"))
        fail(path,
             "it has no group /exchange, so it is not of the Data Exchange layout (/exchange/data, data_white, "
             "data_dark, theta)");
    const auto open = [&](const std::string& name) {
        if (!has(file, name)) fail(path, "there is no dataset /" + name);
        return Dataset(file, path, name);
    };
    const Dataset data = open("exchange/data"), white = open("exchange/data_white"), dark = open("exchange/data_dark");
    data.requireRank(3, "views x rows x columns");
    for (const Dataset* set : {&data, &white, &dark}) set->requireWritten();
    const RowRange range = requireRows(rows, data, path);

    DataExchange scan;
    scan.flat = meanFrame(white, data, range, scan.flatFrames);
    scan.dark = meanFrame(dark, data, range, scan.darkFrames);
    if (has(file, "exchange/theta")) scan.angles = readAngles(open("exchange/theta"), data);
    scan.counts = Projections(int(data.sizes()[2]), range.last - range.first + 1, int(data.sizes()[0]));
    readFrames(data, range, [&](std::size_t first, std::size_t count, const std::vector<float>& piece) {
        std::copy(piece.begin(), piece.end(), scan.counts.view(int(first)));
        scan.complete = report(progress, "reading", double(first + count) / scan.counts.views);
        return scan.complete;
    });
    return scan;
}

}  // namespace raysweep
