/// Which voxels of one lattice hold what is in a voxel of another.
#pragma once

#include "raysweep/volume/grids.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace raysweep {

/// Parts boxes of voxels of a grid among the voxels of another lattice, exactly where the lattices' axes are parallel.
/// Elsewhere a voxel is cut into pieces of at most half a voxel of the other lattice, each of which counts as the box
/// around it: what is even stays nearly even, and nothing is lost.
class Overlap {
  public:
    /// @throw InvalidArgument for transforms that are not linear or are singular, and where the active voxels of `from`
    /// lie so far from the origin of `to` that its voxels cannot be counted
    Overlap(const openvdb::GridBase& from, const openvdb::math::Transform& to);

    /// Volume of a voxel of the grid, in voxels of the lattice.
    double volumeRatio() const { return volumeRatio_; }

    /// Calls `visit(voxel, part)` for the voxels of the lattice that hold a part of `box`, voxels of the grid; the
    /// parts add up to 1. A voxel may come several times.
    template <class Visit>
    void forEachPart(const openvdb::CoordBBox& box, const Visit& visit) const {
        const openvdb::Vec3d low = box.min().asVec3d() - 0.5;
        const openvdb::Coord size = box.dim();
        openvdb::Coord count(1);
        openvdb::Vec3d edges[3], width(0.0);
        for (int a = 0; a < 3; ++a) {
            if (!parallel_) count[a] = std::max(1, int(std::ceil(kPiecesPerVoxel * edges_[a].length() * size[a])));
            edges[a] = edges_[a] * (double(size[a]) / count[a]);
            for (int k = 0; k < 3; ++k) width[k] += std::abs(edges[a][k]);
        }
        const openvdb::Vec3d corner = origin_ + edges_[0] * low[0] + edges_[1] * low[1] + edges_[2] * low[2];
        const double part = 1 / (double(count[0]) * count[1] * count[2]);
        for (int i = 0; i < count[0]; ++i)
            for (int j = 0; j < count[1]; ++j)
                for (int k = 0; k < count[2]; ++k)
                    partBox(corner + edges[0] * (i + 0.5) + edges[1] * (j + 0.5) + edges[2] * (k + 0.5), width, part,
                            visit);
    }

  private:
    static constexpr double kPiecesPerVoxel = 2;

    /// Parts of an interval among cells [i - 1/2, i + 1/2).
    struct Cells {
        int first, count;
        double middle, width;

        Cells(double at, double wide) : middle(at), width(wide) {
            constexpr double kSliver = 1e-6;  // of a cell or of the interval: rounding, where their ends meet
            const double sliver = kSliver * std::min(1.0, wide);
            first = int(std::floor(at - 0.5 * wide + sliver + 0.5));
            count = std::max(1, int(std::ceil(at + 0.5 * wide - sliver + 0.5)) - first);
        }
        double part(int n) const {
            if (count == 1) return 1;
            const double low = n == 0 ? middle - 0.5 * width : first + n - 0.5;
            const double high = n == count - 1 ? middle + 0.5 * width : first + n + 0.5;
            return (high - low) / width;
        }
    };

    template <class Visit>
    static void partBox(const openvdb::Vec3d& middle, const openvdb::Vec3d& width, double whole, const Visit& visit) {
        const Cells x(middle[0], width[0]), y(middle[1], width[1]), z(middle[2], width[2]);
        for (int i = 0; i < x.count; ++i)
            for (int j = 0; j < y.count; ++j) {
                const double row = whole * x.part(i) * y.part(j);
                for (int k = 0; k < z.count; ++k)
                    visit(openvdb::Coord(x.first + i, y.first + j, z.first + k), row * z.part(k));
            }
    }

    openvdb::Vec3d edges_[3], origin_;  ///< of a voxel of the grid, and its point 0, in index space of the lattice
    double volumeRatio_ = 1;
    bool parallel_ = true;
};

}  // namespace raysweep
