/// The light that an object was photographed in while it turned, the lamp standing still. Mattes say where matter is,
/// whatever the light; so a coarse volume gives surfaces and their normals. Colours do not turn, light does: which
/// direction and which share of ambient light leave least of the pictures when colours are what suits them best?
///
/// A first guess (photo_sightings.h) and its opposite are improved by steps of Gauss and Newton for the turns of the
/// light and its diffuse part, of whose effect on the pictures only what no colours could do counts: variable
/// projection, G. H. Golub and V. Pereyra, SIAM J. Numer. Anal. 10, 1973. What matters most: sheets show both sides,
/// with the axis of their surroundings (photo_sheets.h); colours begin black, as those made in another light keep some
/// of it, and are the same for both sides; the last steps see normals as fine as the pictures'.
#pragma once

#include "raysweep/camera/photographs.h"
#include "raysweep/core/progress.h"
#include "raysweep/reconstruct/photo_result.h"
#include "raysweep/reconstruct/reconstruction_grid.h"

#include <optional>
#include <vector>

namespace raysweep {

struct PhotoLightOptions {
    int resolution = 96;   ///< voxels along the longest edge, at most those of the grid, in [8,256]
    int views = 40;        ///< photographs that are looked at, at most, > 1
    int lit = 20;          ///< of these, for the colours, > 1
    int passes = 4;        ///< over these, for the coarse volume, > 0
    int places = 6000;     ///< of surfaces, for the guess, > 0
    int directions = 200;  ///< that are tried for it, > 1
    int steps = 3;         ///< of Gauss and Newton, in a volume of 64 voxels, >= 0
    int fineSteps = 2;     ///< in the finer one, >= 0
    int colorPasses = 3;   ///< over the photographs, for the colours before each step, > 0

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

/// The light that leaves least. Without diffuse light there is nothing to find: then ambient is near to 1 and
/// confidence low. It is low, too, where the opposite light leaves hardly more.
/// @return nothing if `progress` asked to stop
/// @throw InvalidArgument for options out of bounds, and photographs as for photoSart
std::optional<PhotoLight> findLight(const std::vector<Photograph>& photographs, const ReconstructionGrid& grid,
                                    const PhotoLightOptions& options = {}, const ProgressCallback& progress = {});

}  // namespace raysweep
