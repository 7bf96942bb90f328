/// From a lit file to what the renderer needs.
#pragma once

#include "raysweep/render/render.h"
#include "raysweep/volume/transfer_function.h"
#include "raysweep/volume/vdb_io.h"

#include <optional>
#include <string>

namespace raysweep {

/// What of a lit file is shown; what is left open is as it was when the file was lit.
struct LitVolumeOptions {
    std::string density;                       ///< grid, as selectDensity takes it, without the
                                               ///< transfer function it was lit with; empty: what was lit
    std::optional<double> extinction;          ///< per unit density, 1/world unit, finite and not negative
    std::optional<TransferFunction> transfer;  ///< in place of `extinction`: what makes a solid of the density
    std::optional<Color> unshot;  ///< shows power that is still unshot as light of this colour, too; not negative

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

/// Density, extinction, radiosity and emission of a lit file. Of a file that was never lit but has colours of its own,
/// a vec3s grid "Cd" (color_volume.h), these are its source radiance, and density is extinction unless it is said
/// otherwise: so volumes made of photographs look as they were photographed.
/// @throw InvalidArgument if grids are missing or not of the kind that is needed, if the file was written for Blender,
/// and what validate throws
RenderInput litVolume(const VdbFile& file, const LitVolumeOptions& options = {});

}  // namespace raysweep
