/// Datasets of numbers in HDF5 files, read only. Nothing here needs HDF5's own headers.
#pragma once

#include "raysweep/core/sample_type.h"

#include <cstdint>
#include <string>
#include <vector>

namespace raysweep {

/// An identifier of HDF5, closed by the function that belongs to it.
class Hdf5Handle {
  public:
    Hdf5Handle(std::int64_t id, int (*close)(std::int64_t)) : id_(id), close_(close) {}
    ~Hdf5Handle() {
        if (id_ >= 0) close_(id_);
    }
    Hdf5Handle(const Hdf5Handle&) = delete;
    Hdf5Handle& operator=(const Hdf5Handle&) = delete;
    operator std::int64_t() const { return id_; }

  private:
    std::int64_t id_;
    int (*close_)(std::int64_t);
};

/// While it lives, HDF5 keeps its errors instead of printing them.
class QuietHdf5 {
  public:
    QuietHdf5();
    ~QuietHdf5();
    QuietHdf5(const QuietHdf5&) = delete;
    QuietHdf5& operator=(const QuietHdf5&) = delete;

  private:
    int (*print_)(std::int64_t, void*) = nullptr;
    void* data_ = nullptr;
};

/// A file that was opened. @throw IoError if there is none, or it is no HDF5 file or damaged.
class Hdf5File {
  public:
    explicit Hdf5File(const std::string& path);

    bool has(const std::string& name) const;  ///< a link of that name, without the leading slash
    std::vector<std::string> names() const;   ///< of what is at its root
    const std::string& path() const { return path_; }
    std::int64_t id() const { return file_; }

  private:
    QuietHdf5 quiet_;
    std::string path_;
    Hdf5Handle file_;
};

/// Sizes along dimensions, and where a box begins; the last runs fastest.
using Hdf5Extent = std::vector<std::uint64_t>;

/// A dataset of numbers, open: integers of 1, 2, 4 or 8 bytes, floating-point numbers of 2, 4 or 8, of either byte
/// order. What it refuses it says by the dataset's name.
class Hdf5Dataset {
  public:
    /// @param name without the leading slash
    /// @throw IoError if it cannot be opened, holds something else, has no dimension or more than three, or its values
    /// are not all there: never written, or in other files that are missing, no regular files, or too short. HDF5 would
    /// make up zeros, or wait.
    Hdf5Dataset(const Hdf5File& file, const std::string& name);

    const Hdf5Extent& sizes() const { return sizes_; }
    SampleType type() const { return type_; }  ///< of 2 bytes with a point: float32
    std::string sizeText() const;              ///< "181 x 2 x 640"

    /// The text of an attribute; empty if there is none.
    std::string attribute(const std::string& name) const;

    /// Reads the box that starts at `start` and has `count` numbers along each dimension. @throw IoError
    void read(const Hdf5Extent& start, const Hdf5Extent& count, float* to) const;
    void read(const Hdf5Extent& start, const Hdf5Extent& count, double* to) const;

    [[noreturn]] void fail(const std::string& why) const;  ///< @throw IoError

  private:
    void requireWritten(std::int64_t creation) const;
    void requireSources(std::int64_t creation) const;
    void readAs(const Hdf5Extent& start, const Hdf5Extent& count, std::int64_t type, void* to) const;

    std::string path_, name_;
    Hdf5Handle set_;
    Hdf5Extent sizes_;
    SampleType type_ = SampleType::float32;
};

}  // namespace raysweep
