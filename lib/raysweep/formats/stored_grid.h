/// From a dense volume to a sparse grid.
#pragma once

#include "raysweep/core/progress.h"
#include "raysweep/formats/stored_volume.h"
#include "raysweep/volume/grids.h"

namespace raysweep {

/// How samples become voxels: value = sample * scale + offset. Voxels within `tolerance` of `background` are left
/// inactive, and read as `background`. Samples that are not finite become 0.
struct VoxelMapping {
    double scale = 1, offset = 0;
    float background = 0, tolerance = 0;
};

/// A float grid of the samples in `region`. Indices are those of the file, the transform is the file's. Where 8x8x8
/// voxels, or more, are active and the same, they are a tile. Asks `progress` now and then; null if told to stop.
/// Values must fit 32 bit floats.
openvdb::FloatGrid::Ptr gridOf(const StoredVolume& volume, const IndexBox& region, const VoxelMapping& mapping,
                               const ProgressCallback& progress = {});

}  // namespace raysweep
