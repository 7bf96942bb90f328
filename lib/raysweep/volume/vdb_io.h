/// OpenVDB files: read whole or refused, written whole or not at all.
#pragma once

#include "raysweep/volume/grids.h"

#include <string>
#include <vector>

namespace raysweep {

class OutputFile;

/// What a .vdb file holds.
struct VdbFile {
    std::string path;           ///< where it was read from, for messages
    openvdb::GridPtrVec grids;  ///< in the order of the file
    openvdb::MetaMap metadata;  ///< of the file, not of a grid
};

/// The farthest voxel from 0 along an axis that is worked with: sums and differences of coordinates must be integers.
constexpr int kFarthestVoxel = 1 << 29;

/// Reads a whole .vdb file; nothing is left to be loaded later, so damage shows here and not in the middle of the work.
/// @throw IoError if the file is missing, a folder, not OpenVDB, too new, truncated or damaged, or a voxel is
/// farther from 0 than kFarthestVoxel.
VdbFile readVdb(const std::string& path);

/// A grid that cannot be read.
struct UnreadableGrid {
    std::string name, type, error;
};

struct VdbSurvey {
    VdbFile file;                            ///< the grids that can be read
    std::vector<UnreadableGrid> unreadable;  ///< the others
};

/// As readVdb, but grids that cannot be read are passed over, as far as the file says where the next begins.
/// @throw IoError if there is nothing to show: what is wrong is not within a grid
VdbSurvey surveyVdb(const std::string& path);

/// Writes `grids` and file-level `metadata`, compressed as OpenVDB does by default. Values, names, metadata and
/// save-as-half flags are kept as they are. The file appears whole or not at all: on failure whatever stood under
/// `path` is unharmed.
/// @throw IoError if the folder does not exist or is read-only, `path` is a folder, or the disk is full.
void writeVdb(const std::string& path, const openvdb::GridCPtrVec& grids,
              const openvdb::MetaMap& metadata = openvdb::MetaMap());
/// The same to a file that is yet to be committed.
void writeVdb(OutputFile& file, const openvdb::GridCPtrVec& grids,
              const openvdb::MetaMap& metadata = openvdb::MetaMap());

}  // namespace raysweep
