/// What moves through the machine: words of voxels and of rays, and the control word that goes with a partial beam.
///
/// Positions are those of a pass: (u, v) across the rays and k along them, each counted from 0 in the order in which
/// the pass goes (traversal.h). The voxel (u, v, k) and the data that belong to it are in pipeline (u + v + k) mod p.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace raysweep::cube4 {

/// One value for each pipeline.
template <class T>
using Lanes = std::vector<T>;

/// A voxel as it is stored. What its words mean depends on the pass.
template <class Word>
struct Voxel {
    Word scalar{};   ///< extinction; reconstructing: the value that is reconstructed
    Word gain{};     ///< effective albedo; reconstructing: 1 where the voxel takes part, else 0
    Word escape{};   ///< 1 / escape probability, which a table gives for the scalar; only where it is not 1
    Word source{};   ///< power that a ray which passes injects
    Word unshot{};   ///< U
    Word deposit{};  ///< D; reconstructing: sum of the weights of corrections
    Word fresh{};    ///< what a group of passes has added to U so far; reconstructing: sum of corrections
    std::array<float, 3> normal{};  ///< of a surface, outwards, world space; 0: none
};

template <class Word>
bool hasSurface(const Voxel<Word>& voxel) {
    return voxel.normal[0] != 0 || voxel.normal[1] != 0 || voxel.normal[2] != 0;
}

/// A ray as the compositing buffer holds it.
template <class Word>
struct Ray {
    Word value{};   ///< power; projecting: sum of samples; backprojecting: correction
    Word weight{};  ///< projecting: sum of weights; backprojecting: 1 if the ray counts
};

/// What a voxel has for rays: to be resampled to them.
template <class Word>
struct Offer {
    Word part{};   ///< part of a ray that the voxel takes; projecting: 1 where the voxel takes part
    Word given{};  ///< what the voxel gives; projecting: its value
};

/// Weights of two values that are interpolated.
template <class Weight>
struct Between {
    Weight low{}, high{};
};

/// A voxel's place along u or v in a slice, where rays come from a point and each has weights of its own. The ray
/// `above` a voxel is the one between it and the next voxel; there is one at most.
template <class Weight>
struct Place {
    Between<Weight> atVoxel;  ///< weights of this voxel: for the ray above it, and for the one below
    Between<Weight> ending;   ///< weights of the ray below: for the voxel before, and for this one
    bool hasRay = false;      ///< there is a ray above
    int ray = 0;              ///< its lattice coordinate
    int from = -1, to = -1;   ///< where it is in the slices before and after; -1: outside
    double slope = 0;         ///< voxels that it moves on in a slice, in the order of the pass
};

/// What is the same for all rays in a slice.
template <class Weight>
struct SliceSetup {
    int number = 0;              ///< k
    int shiftU = 0, shiftV = 0;  ///< the ray (u, v) of the lattice is at voxel (u + shiftU, v + shiftV), or right above
    int fromU = 0, fromV = 0;    ///< change of the shift since the slice before
    int toU = 0, toV = 0;        ///< to the slice after
    bool first = false, last = false;
    Between<Weight> u, v;           ///< of the voxel below a ray, and the one above
    double slantU = 0, slantV = 0;  ///< by how much the lattice lies further along u and v, within its cell, in the
                                    ///< slice after than in the one before
    int hops = 0;                   ///< pipelines that a finished ray has to move on to be in place for the next slice
    std::vector<Place<Weight>> placesU, placesV;  ///< of all voxels along u and v, where rays come from a point

    /// Rays come from a point: weights and ways are those of places, and `hops` is for rays that keep theirs.
    bool diverges() const { return !placesU.empty(); }
    /// Of the voxels in row v for the rays above them and those below.
    const Between<Weight>& atRow(int row) const { return diverges() ? placesV[std::size_t(row)].atVoxel : v; }
    /// Of the rays that end in row v.
    const Between<Weight>& endingInRow(int row) const { return diverges() ? placesV[std::size_t(row)].ending : v; }
};

/// What stages are built for.
struct StageShape {
    int pipelines = 1;
    int parts = 1;        ///< partial beams of a beam
    bool linear = false;  ///< rays and voxels are interpolated; else each voxel has its ray, and stages pass them on
    int rayWords = 1;     ///< words of a Ray that the pass uses
    int offerWords = 2;   ///< of an Offer
};

/// The control word of a partial beam: p voxels of one beam, or fewer at its end.
template <class Weight>
struct Beam {
    const SliceSetup<Weight>* slice = nullptr;  ///< null: a bubble
    int row = 0;                                ///< v
    int part = 0;                               ///< u = part p ... part p + p - 1
    int first = 0;                              ///< pipeline of the beam's first voxel, (part p + v + k) mod p

    explicit operator bool() const { return slice != nullptr; }
};

/// Calls `visit(lane, u)` for the voxels of a partial beam that lie within `width`.
template <class Weight, class Visit>
void forEachLane(const Beam<Weight>& beam, int pipelines, int width, const Visit& visit) {
    const int begin = beam.part * pipelines, count = width - begin < pipelines ? width - begin : pipelines;
    const int straight = count < pipelines - beam.first ? count : pipelines - beam.first;
    for (int j = 0; j < straight; ++j) visit(std::size_t(beam.first + j), begin + j);
    for (int j = straight; j < count; ++j) visit(std::size_t(j - straight), begin + j);
}

}  // namespace raysweep::cube4
