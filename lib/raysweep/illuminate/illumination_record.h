/// All that it takes to make the sweeps of a solution again, by other means, and to compare voxel by voxel
/// (docs/record.md).
#pragma once

#include "raysweep/core/types.h"
#include "raysweep/illuminate/power_balance.h"
#include "raysweep/scene/light.h"
#include "raysweep/sweep/interpolation.h"
#include "raysweep/sweep/ray_sums.h"
#include "raysweep/volume/grids.h"

#include <string>
#include <vector>

namespace raysweep {

/// One direction. Powers are in the record's unit.
struct RecordedBeam {
    Vec3 direction{0};                    ///< of travel, world
    double column = 0, row = 0;           ///< where the lattice of rays is in the first slice, in [0,1)
    double entering[kMaxChannels] = {0};  ///< power of a ray when it enters the volume
    RaySums sums;
};

/// Beams that passed the volume together.
struct RecordedGroup {
    bool inject = false;  ///< the sources added their power, for each beam
    std::vector<RecordedBeam> beams;
    ChannelPower unshot;  ///< sum of U over all voxels after it
};

/// Only the solution's own level: what coarse ones contributed is in `unshotStart` and `settledDeposit`. Grids are
/// FloatGrid for one wavelength and Vec3SGrid for three, with the voxels active that are not 0. Memory: the grids, of
/// each wavelength two of extinction's size, two more with sources and with a coarse start, and two fields while it is
/// filled.
struct IlluminationRecord {
    /// By which name the density that was lit is chosen in its file, and its checksum there (checksum.h): what was
    /// solved may be made from it. To be filled in by who knows the file.
    std::string density, checksum;

    Index3 low{0}, high{0};  ///< bounding box of the bricks, voxel coordinates, high exclusive
    Matrix3 worldFromIndex;
    bool asPrinted = false;  ///< Exchange::paper
    Interpolation interpolation = Interpolation::nearest;
    int channels = 1;
    double albedo[kMaxChannels] = {0};  ///< if there is no `albedoGrid`
    std::vector<Sun> suns;
    bool otherSources = false;  ///< point lights, quads or emission
    double surfaceOpacity = 0;  ///< opacity of a voxel edge from which on radiosity is not that of a medium; 0: a fog

    double powerUnit = 1;           ///< W; all powers here are in it
    double zeta = 0, mostShot = 0;  ///< of a beam, see ExchangeConstants; 0 without sweeps
    std::vector<RecordedGroup> groups;
    int injections = 0;
    bool settled = false;  ///< a coarse level settled what was left

    openvdb::FloatGrid::Ptr extinction;     ///< that was solved, 1/world unit
    openvdb::GridBase::Ptr albedoGrid;      ///< null: uniform
    openvdb::GridBase::Ptr normals;         ///< of surface voxels, outwards, world space; null: no surfaces
    openvdb::GridBase::Ptr source;          ///< power that each injection adds to U; null: none
    openvdb::GridBase::Ptr scattered;       ///< the part of it that radiosity shows; null: all
    openvdb::GridBase::Ptr emission;        ///< what shines by itself, see Illumination; null: nothing
    openvdb::GridBase::Ptr unshotStart;     ///< U before the first group; null: 0
    openvdb::GridBase::Ptr deposit;         ///< D after the last group, the sum over all of them
    openvdb::GridBase::Ptr unshot;          ///< U after the last group
    openvdb::GridBase::Ptr settledDeposit;  ///< what was added to D after that, of either sign; null: nothing
};

/// Writes the record and, under the same name ending in .vdb, its grids: both files or none.
/// @throw IoError
void writeRecord(const std::string& path, const IlluminationRecord& record);

}  // namespace raysweep
