/// Volumes from other programs: measured, scanned, simulated.
#pragma once

#include "raysweep/core/progress.h"
#include "raysweep/core/types.h"
#include "raysweep/formats/raw_volume.h"
#include "raysweep/formats/stored_volume.h"
#include "raysweep/volume/grids.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace raysweep {

/// What samples are mapped to [0,1] from before anything else.
enum class Normalization {
    automatic,  ///< `type` for unsigned integers as stored, `none` for others, for what the file itself rescales, for
                ///< DICOM, and where scale or offset are given
    type,       ///< the range of the integer type: 0..255, -32768..32767
    data,       ///< the range of the samples that are kept
    none        ///< nothing: voxels have the numbers of the file
};

struct ImportOptions {
    std::optional<RawLayout> raw;    ///< given: the file has no header, and this is what it would say
    std::string series;              ///< SeriesInstanceUID, where there are several; empty: the only one
    std::optional<int> channel;      ///< of several numbers per voxel, counted from 0; see VolumeChoice
    std::optional<int> volumeIndex;  ///< of several volumes, counted from 0
    std::optional<Vec3> spacing;     ///< world units between samples along i, j, k, > 0, instead of the file's
    std::optional<IndexBox> crop;    ///< voxels to keep, indices of the file
    Normalization normalization = Normalization::automatic;
    std::optional<double> scale, offset;  ///< voxel = normalised sample * scale + offset; 1 and 0 if not given
    double background = 0;                ///< value of what is left out, in units of the grid
    double tolerance = 0;                 ///< voxels this close to the background are left out, >= 0
    bool repair = false;                  ///< NaN and infinities become 0 instead of an error
    std::string name = "density";         ///< of the grid

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

struct ImportedVolume {
    openvdb::FloatGrid::Ptr grid;  ///< null if stopped
    std::string format;            ///< "NRRD", "DICOM", "pictures" ...
    SampleType type = SampleType::uint8;
    Index3 dims{0};                  ///< of the file
    Vec3 origin{0}, spacing{1};      ///< world units
    std::string unit;                ///< of the world: "mm", "um" ...; empty: the file does not say
    std::vector<std::string> notes;  ///< what whoever uses the numbers should know; each begins in lower case
    SampleRange range;               ///< of the samples that were kept, as they are in the file
    double scale = 1, offset = 0;    ///< voxel = sample * scale + offset, all mappings together
};

/// Reads `files`: one file of NRRD (.nrrd, .nhdr), MetaImage (.mha, .mhd), NIfTI (.nii, .nii.gz, .hdr with .img) or raw
/// samples; the files of a DICOM series; grey pictures (TIFF, PNG ...) in natural order of their names, one slice
/// each, or all pages of one file; or one folder that holds a DICOM series or pictures. Index (i,j,k) is column, row
/// and slice; i runs fastest in the file. The grid's transform puts it where the file says (docs/import.md), with
/// voxel centres on the samples; files without a place start at the origin with spacing 1.
/// @throw InvalidArgument for options out of bounds, what a volume cannot be made of (see the readers), a crop outside
/// the volume, and values that are NaN or infinite (it names the first) unless `repair` is set.
/// @throw IoError if files are missing, malformed, truncated, or of a kind that is not known.
ImportedVolume importVolume(const std::vector<std::string>& files, const ImportOptions& options,
                            const ProgressCallback& progress = {});

}  // namespace raysweep
