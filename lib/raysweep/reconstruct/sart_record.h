/// All that it takes to make the updates of SART again, by other means, and to compare voxel by voxel (docs/record.md).
#pragma once

#include "raysweep/reconstruct/sart.h"
#include "raysweep/scan/scan.h"

#include <string>
#include <vector>

namespace raysweep {

/// One correction (sart.h, eq. 2).
struct RecordedUpdate {
    std::vector<int> views;  ///< whose rays correct together
    double relaxation = 0;   ///< λ
};

/// Grids lie on the voxels of `grid`, of which those that are not 0 are active. Memory: the volume as a grid, twice
/// with `initial`, and once more for the support.
struct SartRecord {
    ReconstructionGrid grid;
    SartOptions options;
    std::vector<RecordedUpdate> updates;
    openvdb::FloatGrid::Ptr initial;  ///< x before the first update, cut to what is kept and within the bounds; null: 0
    openvdb::FloatGrid::Ptr density;  ///< x after the last one, whatever the tolerance
    openvdb::FloatGrid::Ptr support;  ///< 1 where voxels are kept; null: everywhere
};

/// @throw InvalidArgument if rays are bounds beside `saturation` (Projections::bounds), which a record has no place for
void requireRecordable(const Scan& scan);

/// Writes the record of a reconstruction of `scan` and, under the same name ending in .vdb, its grids and the
/// projections: both files or none. Memory: the projections once more.
/// @throw IoError @throw InvalidArgument as requireRecordable
void writeRecord(const std::string& path, const SartRecord& record, const Scan& scan);

}  // namespace raysweep
