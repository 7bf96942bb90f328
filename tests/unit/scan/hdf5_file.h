/// Scans in the Data Exchange layout, as tests need them.
#pragma once

#include <gtest/gtest.h>
#include <hdf5.h>

#include <functional>
#include <numeric>
#include <string>
#include <vector>

namespace raysweep::test {

/// A file whose datasets a test chooses.
class Hdf5File {
  public:
    explicit Hdf5File(const std::string& path)
        : file_(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT)),
          group_(H5Gcreate2(file_, "exchange", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT)) {}
    ~Hdf5File() { close(); }
    /// What is written is there.
    void close() {
        if (file_ < 0) return;
        H5Gclose(group_);
        H5Fclose(file_);
        file_ = -1;
    }

    void add(const std::string& name, const std::vector<hsize_t>& sizes, hid_t stored, hid_t given, const void* data) {
        const hid_t space = H5Screate_simple(int(sizes.size()), sizes.data(), nullptr);
        const hid_t set = H5Dcreate2(group_, name.c_str(), stored, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
        EXPECT_GE(H5Dwrite(set, given, H5S_ALL, H5S_ALL, H5P_DEFAULT, data), 0);
        H5Dclose(set);
        H5Sclose(space);
    }
    void addCounts(const std::string& name, const std::vector<hsize_t>& sizes, int first) {
        std::vector<int> counts(std::accumulate(sizes.begin(), sizes.end(), std::size_t(1), std::multiplies<>()));
        std::iota(counts.begin(), counts.end(), first);
        add(name, sizes, H5T_STD_U16BE, H5T_NATIVE_INT, counts.data());
    }
    void addAngles(const std::vector<double>& angles) {
        add("theta", {angles.size()}, H5T_IEEE_F32LE, H5T_NATIVE_DOUBLE, angles.data());
    }
    /// An attribute of a dataset.
    void addText(const std::string& dataset, const std::string& name, const std::string& text) {
        const hid_t set = H5Dopen2(group_, dataset.c_str(), H5P_DEFAULT), type = H5Tcopy(H5T_C_S1);
        H5Tset_size(type, text.size());
        const hid_t space = H5Screate(H5S_SCALAR);
        const hid_t attribute = H5Acreate2(set, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT);
        EXPECT_GE(H5Awrite(attribute, type, text.data()), 0);
        H5Aclose(attribute);
        H5Sclose(space);
        H5Tclose(type);
        H5Dclose(set);
    }

  private:
    hid_t file_, group_;
};

}  // namespace raysweep::test
