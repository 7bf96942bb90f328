/// How a pass goes through the volume: which memory axis is which, and where the lattice of rays lies in each slice.
///
/// Rays of one direction form a lattice of one ray per voxel of a slice. From slice to slice all of them move sideways
/// by the same slope, at most a voxel. A pass counts u, v and k upwards if light goes up the memory's axis k, and all
/// three downwards if it goes down: then the neighbour along a beam, across beams and across slices is the same
/// neighbour of the ring (cube4.md).
#pragma once

#include "cube4/words.h"

#include "raysweep/core/types.h"

#include <array>

namespace raysweep::cube4 {

/// A parallel front, in voxels of the memory.
struct Direction {
    Vec3 alongIndex{0, 0, 1};         ///< of travel, index space; any length but 0
    double offsetU = 0, offsetV = 0;  ///< where the lattice is in the first slice, along the axes below, in [0,1)
};

enum class Resampling {
    nearest,  ///< a voxel meets the ray whose lattice cell it is in: each meets one
    linear    ///< rays and voxels are resampled to each other with bilinear weights
};

/// Where rays can be: the content of the memory, voxels.
struct ContentBox {
    Index3 low{0}, high{0};  ///< high exclusive
};

struct Traversal {
    int major = 2, axisU = 0, axisV = 1;  ///< memory axes
    bool descending = false;              ///< all three are counted downwards
    Index3 size{0};                       ///< of the box that is passed: along u, v and k
    Index3 origin{0};                     ///< memory coordinates of (0,0,0)
    int reach = 0;                        ///< voxels above the one at the shift that a ray meets: 1 if `linear`
    double stepLength = 1;                ///< length of a ray in a slice, in units of `alongIndex`' length

    /// Slope and offset of the lattice along u and v, in the memory's sense.
    std::array<double, 2> slope{{0, 0}}, offset{{0, 0}};

    /// Memory coordinate along `axis` of position `at` of a pass.
    int memoryCoordinate(int axis, int at) const { return descending ? origin[axis] - at : origin[axis] + at; }
};

/// `linear` needs a layer of empty voxels around the content: rays next to it meet it with a part of their weight.
/// @param memory dimensions of the memory; for `linear` the pass goes over all of it across the rays
Traversal traverse(const Index3& memory, const ContentBox& content, const Direction& direction, Resampling resampling);

/// The slices of a pass in order. @param ending voxels along u and v from where a ray is read to where it is finished
template <class Arithmetic>
std::vector<SliceSetup<typename Arithmetic::Weight>> slicesOf(const Traversal& traversal, const Arithmetic& arithmetic,
                                                              int ending);
/// Rays are read at the voxel below them, and finished at the one above.
template <class Arithmetic>
std::vector<SliceSetup<typename Arithmetic::Weight>> slicesOf(const Traversal& traversal,
                                                              const Arithmetic& arithmetic) {
    return slicesOf(traversal, arithmetic, traversal.reach);
}

/// The lattice coordinate of the ray that has its voxel at position 0 in slice k, u or v.
struct LatticeShift {
    int shift;        ///< in the order of the pass
    double fraction;  ///< part of the way from the voxel at the shift to the one above it
};
LatticeShift latticeShift(const Traversal& traversal, int lateral, int slice);

}  // namespace raysweep::cube4
