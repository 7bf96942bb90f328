/// An explosion: smoke, and fire that breaks out of it.
#pragma once

#include "raysweep/phantoms/phantom.h"

namespace raysweep {

/// On one lattice, centred at the world's origin.
struct Explosion {
    openvdb::FloatGrid::Ptr density;  ///< "density", fog; thin where it is hot
    openvdb::Vec3SGrid::Ptr fire;  ///< "fire", emitted power per volume, W/world unit^3; also where there is no smoke
};

/// Radiates most, and in red: W/world unit^3, for an explosion of two world units.
constexpr double kBrightestFire = 150;

/// Billowing balls around the middle, hot inside and between their bumps. What is hot shines as a black body does, by
/// Wien's law at 610, 550 and 465 nm: from dark red at the rims to a yellowish white. `size` voxels are the edge of the
/// cube that it fits into.
/// The same options give the same bits, whatever the number of threads.
Explosion makeExplosion(const PhantomOptions& options);

}  // namespace raysweep
