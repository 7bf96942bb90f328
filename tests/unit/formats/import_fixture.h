/// What the tests of importing share.
#pragma once

#include "raysweep/core/error.h"
#include "raysweep/formats/itk_volume.h"
#include "raysweep/formats/volume_import.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "support/temporary_folder.h"
#include "support/volume_files.h"

namespace raysweep::test {

using openvdb::Coord;

/// A number that tells where in a volume it stands; none is 0.
inline int label(int i, int j, int k) {
    return 1 + i + 10 * j + 100 * k;
}

template <class Sample>
std::vector<Sample> labels(const Index3& dims) {
    std::vector<Sample> samples;
    for (int k = 0; k < dims.z; ++k)
        for (int j = 0; j < dims.y; ++j)
            for (int i = 0; i < dims.x; ++i) samples.push_back(Sample(label(i, j, k)));
    return samples;
}

inline const Index3 kDims(3, 4, 5);

/// All voxels are what `labels` made.
inline void expectLabels(const ImportedVolume& volume, const Index3& dims, double factor = 1) {
    ASSERT_TRUE(volume.grid);
    EXPECT_EQ(volume.dims, dims);
    EXPECT_EQ(volume.grid->activeVoxelCount(), std::uint64_t(dims.x) * dims.y * dims.z);
    for (int k = 0; k < dims.z; ++k)
        for (int j = 0; j < dims.y; ++j)
            for (int i = 0; i < dims.x; ++i)
                EXPECT_FLOAT_EQ(volume.grid->tree().getValue(Coord(i, j, k)), float(label(i, j, k) * factor))
                    << i << " " << j << " " << k;
}

inline void expectAt(const ImportedVolume& volume, const Coord& index, const Vec3& world) {
    const openvdb::Vec3d at = volume.grid->indexToWorld(index);
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(at[axis], world[axis], 1e-6) << "axis " << axis;  // stored floats
}

/// The message of the error that importing ends in.
inline std::string errorOf(const std::vector<std::string>& files, const ImportOptions& options = {}) {
    try {
        importVolume(files, options);
    } catch (const Error& e) {
        return e.what();
    }
    return "no error";
}

inline void expectError(const std::vector<std::string>& files, const std::string& part,
                        const ImportOptions& options = {}) {
    const std::string message = errorOf(files, options);
    EXPECT_NE(message.find(part), std::string::npos) << message << "\n  lacks: " << part;
}

inline ImportOptions rawOptions(const Index3& dims, SampleType type) {
    ImportOptions options;
    options.raw = RawLayout{dims, type};
    return options;
}

class Import : public ::testing::Test {
  protected:
    TemporaryFolder folder;
};

/// For formats that ITK reads.
class ImportItk : public Import {
  protected:
    void SetUp() override {
        if (!hasItk()) GTEST_SKIP() << "this build has no ITK";
    }
};

}  // namespace raysweep::test
