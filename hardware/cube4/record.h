/// Runs of `raysweep light` and `raysweep ct` as they were recorded (docs/record.md): what was done, in which order,
/// and what came of it. The numbers come from files; none of them is computed by the library that is judged.
#pragma once

#include "cube4/dense_volume.h"
#include "cube4/illumination.h"

#include "raysweep/core/types.h"
#include "raysweep/volume/vdb_io.h"

#include <optional>
#include <string>
#include <vector>

namespace raysweep::cube4 {

/// A file of a run.
struct RecordFile {
    std::string path;
    VdbFile fields;  ///< the volumes beside it
};

/// A beam of a recorded sweep, for each of up to three wavelengths.
struct RecordedBeam {
    Vec3 direction{0};
    double offsetU = 0, offsetV = 0;
    std::vector<double> entering;          ///< power of a ray
    std::vector<double> entered, escaped;  ///< of all rays
};
struct RecordedGroup {
    bool inject = false;
    std::vector<RecordedBeam> beams;
};
struct RecordedSun {
    Vec3 direction{0};
    std::vector<double> irradiance;  ///< W / world unit^2
};

struct IlluminationRecord {
    RecordFile file;
    std::string grid, checksum;  ///< of the volume that was lit
    DenseBox box;                ///< that was swept
    ExchangeRule rule = ExchangeRule::corrected;
    Resampling resampling = Resampling::nearest;
    int channels = 1;
    std::vector<double> albedo;  ///< empty: a grid
    double powerUnit = 1;        ///< W
    double zeta = 0.5, mostShot = 1;
    std::vector<RecordedSun> suns;
    bool otherSources = false;  ///< points, quads, emission
    double surfaceOpacity = 0;  ///< of a voxel edge, from which on what is behind a surface is solid; 0: a fog
    std::vector<RecordedGroup> groups;
    int injections = 0;
};

/// One view's rays. World units.
struct RecordedView {
    Vec3 source{0}, direction{0};
    Vec3 origin{0}, column{0}, row{0};  ///< of the detector's pixels
};
struct RecordedUpdate {
    std::vector<int> views;
    double relaxation = 0;
};

struct ReconstructionRecord {
    RecordFile file;
    DenseBox box;    ///< of the voxels, in the result's index space
    Vec3 origin{0};  ///< world position of the centre of voxel `box.low`
    bool cone = false;
    int width = 0, height = 0;
    std::vector<RecordedView> views;
    double totalVariation = 0;
    std::optional<double> lower, upper, saturation;
    bool support = false;
    std::vector<RecordedUpdate> updates;
};

/// Which kind of run a file is of. @throw IoError if it is none
std::string recordKind(const std::string& path);

/// @throw IoError naming file and field for what is missing or cannot be understood; InvalidArgument for a run of more
/// than `mostVoxels` voxels
IlluminationRecord readIlluminationRecord(const std::string& path, std::size_t mostVoxels);
ReconstructionRecord readReconstructionRecord(const std::string& path, std::size_t mostVoxels);

/// The grid called `name` of the volumes beside a record. @throw IoError unless it is there, or if it is optional null
openvdb::GridBase::ConstPtr fieldOf(const RecordFile& file, const std::string& name, bool optional = false);

}  // namespace raysweep::cube4
