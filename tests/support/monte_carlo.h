/// Monte Carlo light transport in a dense voxel grid: the reference that the sweep solver is measured against. It
/// shares no transport code with the library.
///
/// Grids are cubic voxels of constant extinction with isotropic scattering; voxel (i,j,k) has index (i * ny + j) * nz +
/// k. Photon packets fly from collision to collision through the exact lengths they have in each voxel (Amanatides &
/// Woo 1987) and leave a track-length estimate of the fluence behind (Lux & Koblinger, Monte Carlo Particle Transport
/// Methods, 1991, chapter 6). Light, units: see each field. Faces are numbered x low, x high, y low, y high, z low, z
/// high.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "raysweep/core/types.h"

namespace raysweep::test {

/// Parallel beam over the whole bounding box.
struct McSun {
    Vec3 direction;         ///< the way the light travels; any length
    double irradiance = 1;  ///< at normal incidence [W m^-2]
};

/// The same radiance from all directions, through the chosen faces of the box.
struct McSky {
    double radiance = 1;  ///< [W m^-2 sr^-1]
    std::array<bool, 6> faces = {true, true, true, true, true, true};
};

/// Isotropic point light, inside the box or outside it.
struct McPointLight {
    Vec3 position;     ///< world
    double power = 1;  ///< into all 4 pi [W]
};

struct McScene {
    int nx = 1, ny = 1, nz = 1;
    double h = 1;                               ///< voxel edge [world unit]
    std::vector<double> extinction;             ///< per voxel [1/world unit]
    std::vector<double> albedo = {1.0};         ///< one for all voxels, or one per voxel [0,1]
    double g = 0;                               ///< mean cosine of Henyey and Greenstein's phase function, (-1,1)
    std::vector<double> emission;               ///< per voxel, emitted power density into 4 pi [W m^-3]; may be empty
    Vec3 origin = Vec3(0, 0, 0);                ///< world position of the low corner
    bool periodicX = false, periodicY = false;  ///< what leaves on one side enters on the other: an infinite slab
    std::optional<McSun> sun;
    std::optional<McSky> sky;
    std::vector<McPointLight> pointLights;
    /// Packets start at evenly spread points: good where light is hardly scattered. Such points of seven coordinates
    /// lie on few planes, so where block averages of scattered light count, independent points have a third of the
    /// noise.
    bool evenLight = true;
};

/// An estimate and its standard error.
struct McTotal {
    double value = 0;
    double error = 0;
};

struct McResult {
    // Per voxel.
    std::vector<double> fluence;              ///< phi [W m^-2]
    std::vector<double> fluenceError;         ///< standard error of phi
    std::vector<double> collided;             ///< sigma_t phi [W m^-3]
    std::vector<double> sourceRadiance;       ///< albedo phi / 4 pi + emission / (4 pi sigma_t) [W m^-2 sr^-1]: what a
                                              ///< renderer multiplies with sigma_t T ds; no emission where sigma_t = 0
    std::vector<double> sourceRadianceError;  ///< standard error of it
    // Of the whole box [W]; `injected` = `absorbed` + `escaped` in every run but for rounding.
    McTotal injected, absorbed, escaped;
    std::array<McTotal, 6> escapedPerFace;
    std::array<McTotal, 6> escapedUncollidedPerFace;  ///< the part of `escapedPerFace` that never collided
    std::uint64_t histories = 0;                      ///< photon packets followed
};

/// Follows about `histories` packets (at least one per light in each of 64 batches). The result depends on `seed` and
/// not on the number of threads. Memory: 16 bytes per voxel and batch in flight (8) besides the scene and the result.
/// @throw std::invalid_argument if an array's length is wrong, a value is out of range, there is no light, or a point
/// light
///        is outside a periodic box.
McResult monteCarlo(const McScene& scene, std::uint64_t histories, std::uint64_t seed);

}  // namespace raysweep::test
