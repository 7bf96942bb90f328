#include "raysweep/render/bake.h"

#include "raysweep/core/memory.h"
#include "raysweep/core/parallel.h"
#include "raysweep/core/require.h"
#include "raysweep/mesh/mesh_shells.h"
#include "raysweep/render/occupancy.h"
#include "raysweep/render/sampler.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace raysweep {
namespace {

constexpr double kOutside = 1.5, kInside = 2, kStep = 0.25;  ///< voxels along the normal
constexpr double kFaint = 0.02;                              ///< less opacity than this is no surface
constexpr int kMargin = 4;                                   ///< texels
constexpr std::size_t kPerReport = 1 << 18;                  ///< places

struct Place {
    Vec3 position, normal;  ///< world units; 0: no place
};

/// What is seen of places; one for each thread.
template <class RadiosityGrid>
class SurfaceEye {
  public:
    SurfaceEye(const RenderInput& volume, const openvdb::FloatGrid& density)
        : density_(density),
          radiosity_(static_cast<const RadiosityGrid&>(*volume.radiosity)),
          densities_(density),
          radiosities_(radiosity_),
          voxel_(std::cbrt(density.transform().voxelVolume())),
          depthPerDensity_(volume.extinctionScale * kStep * voxel_) {}

    /// The radiosity of a place; none if there is next to nothing of the volume.
    std::optional<Color> look(Place place, BakeCounts& counts) {
        ++counts.places;
        if (densityAt(place, kOutside) > densityAt(place, -kOutside)) {
            place.normal = -place.normal;
            ++counts.turned;
        }
        Color sum = grey(0);
        double transmittance = 1;
        for (double height = kOutside - kStep / 2; height > -kInside; height -= kStep) {
            const double opacity = -std::expm1(-depthPerDensity_ * densityAt(place, height));
            if (!(opacity > 0)) continue;
            sum += radiosityAt(place, height) * float(transmittance * opacity);
            transmittance *= 1 - opacity;
        }
        if (1 - transmittance >= kFaint) return sum * float(1 / (1 - transmittance));
        ++counts.missed;
        return std::nullopt;
    }

  private:
    openvdb::Vec3d at(const Place& place, double height) const {
        const Vec3 p = place.position + place.normal * (height * voxel_);
        return openvdb::Vec3d(p.x, p.y, p.z);
    }
    double densityAt(const Place& place, double height) {
        return double(densities_(density_.worldToIndex(at(place, height))));
    }
    Color radiosityAt(const Place& place, double height) {
        const auto s = radiosities_(radiosity_.worldToIndex(at(place, height)));
        if constexpr (std::is_same_v<RadiosityGrid, openvdb::FloatGrid>)
            return grey(s);
        else
            return Color(s.x(), s.y(), s.z());
    }

    const openvdb::FloatGrid& density_;
    const RadiosityGrid& radiosity_;
    LinearSampler<openvdb::FloatGrid> densities_;
    LinearSampler<RadiosityGrid> radiosities_;
    double voxel_, depthPerDensity_;
};

/// Calls `take(i, colour)` for every place i. @return false if it was stopped
template <class RadiosityGrid, class Take>
bool lookAtAll(const RenderInput& volume, const openvdb::FloatGrid& density, const std::vector<Place>& places,
               const ProgressCallback& progress, BakeCounts& counts, const Take& take) {
    constexpr std::size_t kChunk = 1024;
    for (std::size_t begin = 0; begin < places.size(); begin += kPerReport) {
        if (!report(progress, "bake", double(begin) / double(places.size()))) return false;
        const std::size_t end = std::min(begin + kPerReport, places.size());
        std::vector<BakeCounts> chunks((end - begin + kChunk - 1) / kChunk);
        parallelFor(chunks.size(), [&](std::size_t c) {
            SurfaceEye<RadiosityGrid> eye(volume, density);
            for (std::size_t i = begin + c * kChunk; i < std::min(end, begin + (c + 1) * kChunk); ++i)
                if (places[i].normal != Vec3(0)) take(i, eye.look(places[i], chunks[c]));
        });
        for (const BakeCounts& chunk : chunks)
            counts.places += chunk.places, counts.turned += chunk.turned, counts.missed += chunk.missed;
    }
    return report(progress, "bake", 1);
}

/// Calls `visit(texel, weights)` for the texels whose centres lie in triangle `t` of an atlas of `side` x `side`.
template <class Visit>
void forEachTexel(const TriangleMesh& mesh, const TriangleMesh::Triangle& t, int side, const Visit& visit) {
    std::array<Imath::V2d, 3> p;  // pixels, y downwards
    for (std::size_t i = 0; i < 3; ++i)
        p[i] = {double(mesh.texture[t[i]][0]) * side, (1 - double(mesh.texture[t[i]][1])) * side};
    const double area = (p[1] - p[0]).cross(p[2] - p[0]);
    if (area == 0 || !std::isfinite(area)) return;
    const auto first = [&](int axis) {
        return std::clamp(std::min({p[0][axis], p[1][axis], p[2][axis]}) - 0.5, 0.0, double(side));
    };
    const auto last = [&](int axis) { return std::min(side - 1.0, std::max({p[0][axis], p[1][axis], p[2][axis]})); };
    for (int y = int(std::ceil(first(1))); y <= last(1); ++y)
        for (int x = int(std::ceil(first(0))); x <= last(0); ++x) {
            const Imath::V2d c(x + 0.5, y + 0.5);
            const Vec3 w((p[1] - c).cross(p[2] - c) / area, (p[2] - c).cross(p[0] - c) / area,
                         (p[0] - c).cross(p[1] - c) / area);
            if (w.x >= 0 && w.y >= 0 && w.z >= 0) visit(std::size_t(y) * std::size_t(side) + std::size_t(x), w);
        }
}

std::vector<Place> atlasPlaces(const TriangleMesh& mesh, const std::vector<Vec3>& normals, int side) {
    const double texels = double(side) * double(side);
    requireBytes(texels * double(sizeof(Place) + 3 * sizeof(float) + 2),
                 "atlas of " + std::to_string(side) + " x " + std::to_string(side) + " pixels needs",
                 "make it smaller");
    std::vector<Place> places(std::size_t(side) * std::size_t(side), Place{Vec3(0), Vec3(0)});
    for (const TriangleMesh::Triangle& t : mesh.triangles)
        forEachTexel(mesh, t, side, [&](std::size_t texel, const Vec3& w) {
            const auto mixed = [&](const std::vector<Vec3>& v) {
                return v[t[0]] * w.x + v[t[1]] * w.y + v[t[2]] * w.z;
            };
            places[texel] = {mixed(mesh.positions), mixed(normals).normalized()};
        });
    return places;
}

/// Texels beside known ones take their mean.
void grow(Image& atlas, std::vector<char>& known) {
    const std::vector<char> before = known;
    const int side = atlas.width;
    const auto index = [&](int x, int y) { return std::size_t(y) * std::size_t(side) + std::size_t(x); };
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            if (before[index(x, y)]) continue;
            Color sum = grey(0);
            int count = 0;
            for (int v = std::max(0, y - 1); v <= std::min(side - 1, y + 1); ++v)
                for (int u = std::max(0, x - 1); u <= std::min(side - 1, x + 1); ++u)
                    if (before[index(u, v)]) {
                        const float* const p = atlas.at(u, v);
                        sum += Color(p[0], p[1], p[2]);
                        ++count;
                    }
            if (count == 0) continue;
            for (int c = 0; c < 3; ++c) atlas.at(x, y)[c] = sum[c] / float(count);
            known[index(x, y)] = 1;
        }
}

template <class RadiosityGrid>
BakedMesh bake(const RenderInput& volume, const TriangleMesh& asGiven, const BakeOptions& options,
               const ProgressCallback& progress) {
    const openvdb::FloatGrid::ConstPtr density = zeroWhereInactive(volume.density);
    const TriangleMesh mesh = facingAlike(asGiven, shellsOf(asGiven));
    const std::vector<Vec3> normals = cornerNormals(mesh);
    std::vector<Place> corners;
    for (std::size_t i = 0; i < normals.size(); ++i) corners.push_back({mesh.positions[i], normals[i]});
    BakedMesh made{mesh, {}, {}, {}, true};
    made.mesh.colors.assign(mesh.positions.size(), grey(0));
    made.complete = lookAtAll<RadiosityGrid>(volume, *density, corners, progress, made.corners,
                                             [&](std::size_t i, const std::optional<Color>& color) {
                                                 if (color) made.mesh.colors[i] = *color;
                                             });
    if (options.atlas == 0 || !made.complete) return made;
    made.atlas = Image(options.atlas, options.atlas, 3);
    const std::vector<Place> texels = atlasPlaces(mesh, normals, options.atlas);
    std::vector<char> known(texels.size());
    made.complete = lookAtAll<RadiosityGrid>(volume, *density, texels, progress, made.texels,
                                             [&](std::size_t i, const std::optional<Color>& color) {
                                                 known[i] = color.has_value();
                                                 for (int c = 0; c < 3 && color; ++c)
                                                     made.atlas.pixels[3 * i + std::size_t(c)] = (*color)[c];
                                             });
    for (int margin = 0; margin < kMargin; ++margin) grow(made.atlas, known);
    return made;
}

}  // namespace

void BakeOptions::validate() const {
    requireField(atlas >= 0 && atlas <= 32768, "atlas", atlas, "between 0 and 32768 pixels");
}

BakedMesh bakeRadiosity(const RenderInput& volume, const TriangleMesh& mesh, const BakeOptions& options,
                        const ProgressCallback& progress) {
    options.validate();
    volume.validate();
    if (options.atlas > 0 && mesh.texture.empty())
        throw about("atlas", InvalidArgument("the mesh has no texture coordinates"));
    return volume.radiosity->isType<openvdb::FloatGrid>() ? bake<openvdb::FloatGrid>(volume, mesh, options, progress)
                                                          : bake<openvdb::Vec3SGrid>(volume, mesh, options, progress);
}

}  // namespace raysweep
