/// A recorded run of `raysweep light` once more, in the dense machine, voxel by voxel compared.
#pragma once

#include "cube4/perspective.h"
#include "cube4/record.h"

#include "raysweep/core/progress.h"

#include <string>
#include <vector>

namespace raysweep::cube4 {

/// How two fields agree.
struct Agreement {
    double rms = 0;     ///< RMS difference over the RMS of the software's
    double worst = 0;   ///< largest difference, over the software's largest value
    Index3 worstAt{0};  ///< its voxel
    std::size_t voxels = 0;
};

/// @param theirs the software's; where it has no voxel it is 0
Agreement compareFields(const DenseField& ours, const openvdb::GridBase& theirs, const DenseBox& box, int channel);

/// The same of all voxels of two fields.
Agreement compareFields(const DenseField& ours, const DenseField& theirs, const DenseBox& box);

/// The worse of each of the two.
Agreement worseOf(const Agreement& a, const Agreement& b);

struct ReplaySetup {
    int pipelines = 16;
    bool overlap = true;
    RaySampling sampling;                ///< of cones
    std::optional<NumberFormat> format;  ///< none: floats
    Trace* trace = nullptr;
};

struct ReplayResult {
    Agreement deposit, unshot;                ///< of the worst wavelength, to the software
    Agreement depositToFloat, unshotToFloat;  ///< with a format: to the machine with floats
    Agreement source;     ///< direct light of suns as the machine finds it; 0 voxels if there is none to compare
    double rayPower = 0;  ///< largest relative difference of what the rays of a front carried at both ends
    double balance = 0;   ///< (injected - absorbed - escaped - unshot) / injected, of what the machine holds
    std::vector<DenseField> depositFields, radiosityFields;  ///< of each wavelength
    double startShare =
        0;  ///< of the power of sources and start, what was unshot before the first sweep, from the record
    bool sourceFromRecord = false;  ///< point lights or emission: direct light was not judged
    double settledShare = 0;        ///< of the deposit that was settled on a coarser level, and taken from the record
    int sweeps = 0;
    bool complete = true;  ///< false: stopped by the progress callback
    Counters counters;     ///< of all wavelengths
    std::size_t passes = 0, bytesPerModule = 0, bufferBytes = 0;
};

/// Does all groups of the record. @throw InvalidArgument where the format cannot hold the powers
ReplayResult replay(const IlluminationRecord& record, const ReplaySetup& setup, const ProgressCallback& progress = {});

/// How the answer agrees with a lit file's.
struct RadiosityJudgement {
    Agreement agreement;                 ///< of the worst wavelength
    std::size_t voxels = 0, active = 0;  ///< judged, of those that are not empty
};

/// Surfaces are left out, and in solids what is as opaque as to be behind one.
RadiosityJudgement judgeRadiosity(const IlluminationRecord& record, const ReplayResult& result,
                                  const openvdb::GridBase& radiosity);

/// One wavelength of what a record says of the medium.
DenseMedium mediumOf(const IlluminationRecord& record, int channel);

/// @throw InvalidArgument unless `grid` is the volume that was lit
void requireSameVolume(const IlluminationRecord& record, const openvdb::FloatGrid& grid);

}  // namespace raysweep::cube4
