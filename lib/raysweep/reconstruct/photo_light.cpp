#include "raysweep/reconstruct/photo_light.h"

#include "raysweep/core/parallel.h"
#include "raysweep/core/require.h"
#include "raysweep/reconstruct/photo_sart.h"
#include "raysweep/reconstruct/photo_step.h"
#include "raysweep/reconstruct/photo_views.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace raysweep {
namespace {

/// A coarse volume in bricks, with normals.
struct Surfaces {
    ReconstructionGrid grid;
    CompositeLayout layout;
    std::vector<CompositeVoxel> voxels;
    std::vector<CompositeVoxel> shown;  ///< in the light of a view
    std::vector<PackedNormal> normals;
};

/// How bright a place is in one view.
struct Sighting {
    float weight = 0, brightness = 0;
    float normal[3] = {0, 0, 0};  ///< as if it were the camera that stood still where the first was
};

/// Sightings of all places, `views` for each.
struct Sightings {
    std::size_t views = 0;
    std::vector<Sighting> all;
    double power = 0;  ///< Σ w b²
};

/// Evenly, `most` of them; the first always.
std::vector<Photograph> someOf(const std::vector<Photograph>& photographs, int most) {
    const std::size_t count = std::min(photographs.size(), std::size_t(most));
    std::vector<Photograph> some;
    for (std::size_t i = 0; i < count; ++i) some.push_back(photographs[i * photographs.size() / count]);
    return some;
}

ReconstructionGrid coarser(ReconstructionGrid grid, int resolution) {
    const Vec3 size = Vec3(grid.dims.x, grid.dims.y, grid.dims.z) * grid.spacing;
    grid.spacing = std::max({size.x, size.y, size.z}) / resolution;
    for (int axis = 0; axis < 3; ++axis)
        grid.dims[axis] = std::max(1, int(std::ceil(size[axis] / grid.spacing - 1e-6)));
    return grid;
}

Surfaces surfacesOf(const PhotoReconstruction& volume, const ReconstructionGrid& grid) {
    Surfaces to;
    to.grid = grid;
    std::vector<MaskedBrick> bricks;
    for (auto leaf = volume.density->tree().cbeginLeaf(); leaf; ++leaf) {
        MaskedBrick brick{Index3(leaf->origin().x(), leaf->origin().y(), leaf->origin().z()), {}};
        for (openvdb::Index i = 0; i < 512; ++i)
            if (leaf->isValueOn(i)) brick.mask[i >> 6] |= std::uint64_t(1) << (i & 63);
        bricks.push_back(brick);
    }
    to.layout = compositeLayout(grid.dims, bricks);
    to.voxels.resize(to.layout.voxelCount());
    to.normals.resize(to.layout.voxelCount());
    to.shown.resize(to.layout.voxelCount());
    for (std::size_t b = 1; b < to.layout.brickCount(); ++b) {
        const openvdb::Coord origin(to.layout.origins[b].x, to.layout.origins[b].y, to.layout.origins[b].z);
        const auto* density = volume.density->tree().probeConstLeaf(origin);
        const auto* color = volume.color->tree().probeConstLeaf(origin);
        for (openvdb::Index i = 0; i < 512; ++i) {
            if (!density->isValueOn(i)) continue;
            const openvdb::Vec3s c = color->getValue(i);
            to.voxels[b * 512 + i] = {density->getValue(i) * float(grid.spacing), c[0], c[1], c[2]};
        }
    }
    for (std::size_t b = 1; b < to.layout.brickCount(); ++b)
        brickNormals(to.layout, to.voxels.data(), b, &to.normals[b * 512]);
    return to;
}

/// Gives a sample its visibility, and that times the brightness it is seen in: its own, and of what the picture shows
/// more than the volume the part that the shortest way to the picture gives it.
void sightRule(const PhotoRays& rays, std::size_t r, const RaySamples& s, CompositeVoxel* values) {
    const auto& pixel = rays.pixels[r];
    const float more = (pixel[0] + pixel[1] + pixel[2]) - (s.color.red + s.color.green + s.color.blue);
    float squares = 1e-4f;
    for (std::size_t i = 0; i < s.count; ++i) {
        const float seen = s.transmittances[i] - s.transmittances[i + 1];
        squares += seen * seen;
    }
    for (std::size_t i = 0; i < s.count; ++i) {
        const float seen = s.transmittances[i] - s.transmittances[i + 1];
        const CompositeVoxel& c = s.samples[i];
        const float weight = rays.shares[r].at(s.numbers[i]) * seen * seen; static const int full = int(getenv("FULL")?1:0); if (full) { values[i] = {weight, weight * (c.red+c.green+c.blue) + rays.shares[r].at(s.numbers[i])*seen*more,0,0}; continue; }
        values[i] = {weight, weight * (c.red + c.green + c.blue + seen * more / squares), 0, 0};
    }
}

ViewLight lightOf(const Shading& shading, const PhotoCamera& camera, const PhotoCamera& first) {
    const Vec3 light = lightBeside(camera, first, shading.light).normalized();
    return {float(shading.ambient), float(shading.diffuse), {float(-light.x), float(-light.y), float(-light.z)}};
}

/// What all pictures show of all voxels: Σ w and Σ w b, view after view.
std::vector<std::vector<CompositeVoxel>> sightAll(const std::vector<Photograph>& pictures, Surfaces& surfaces, const Shading& shading) {
    std::vector<std::vector<CompositeVoxel>> sums(pictures.size());
    PhotoRays rays;
    CompositeTape tape;
    for (std::size_t n = 0; n < pictures.size(); ++n) {
        sums[n].resize(surfaces.layout.voxelCount());
        setRays(rays, pictures[n], surfaces.grid, surfaces.layout, 1, 0);
        const ViewLight light = lightOf(shading, pictures[n].camera, pictures.front().camera);
        for (std::size_t b = 1; b < surfaces.layout.brickCount(); ++b)
            lightBrick(&surfaces.voxels[b * 512], &surfaces.normals[b * 512], light, &surfaces.shown[b * 512]);
        compositeSpread(
            surfaces.layout, surfaces.shown.data(), rays.rays,
            [&](std::size_t r, const RaySamples& samples, CompositeVoxel* values) {
                sightRule(rays, r, samples, values);
            },
            tape, sums[n].data());
    }
    return sums;
}

/// The voxels that are seen best, at most `most`.
std::vector<std::size_t> bestSeen(const std::vector<std::vector<CompositeVoxel>>& sums, const Surfaces& surfaces,
                                  std::size_t most) {
    std::vector<std::pair<float, std::size_t>> ranked;
    for (std::size_t i = 512; i < surfaces.voxels.size(); ++i) {
        const PackedNormal n = surfaces.normals[i];
        float weight = 0;
        for (const auto& view : sums) weight += view[i].extinction;
        if (weight > 0 && (n.x | n.y | n.z) != 0) ranked.push_back({-weight, i});
    }
    std::sort(ranked.begin(), ranked.end());
    ranked.resize(std::min(ranked.size(), most));
    std::vector<std::size_t> best;
    for (const auto& [weight, i] : ranked) best.push_back(i);
    return best;
}

Sightings sightingsOf(const std::vector<Photograph>& pictures, Surfaces& surfaces, const Shading& shading, std::size_t places) {
    const auto sums = sightAll(pictures, surfaces, shading);
    Sightings to;
    to.views = pictures.size();
    for (const std::size_t i : bestSeen(sums, surfaces, places))
        for (std::size_t n = 0; n < to.views; ++n) {
            const CompositeVoxel& sum = sums[n][i];
            const PackedNormal packed = surfaces.normals[i];
            const Vec3 normal =
                lightBeside(pictures.front().camera, pictures[n].camera, Vec3(packed.x, packed.y, packed.z) / 32767.0);
            const float brightness = sum.extinction > 0 ? sum.red / sum.extinction : 0;
            to.all.push_back({sum.extinction, brightness, {float(normal.x), float(normal.y), float(normal.z)}});
            to.power += double(sum.extinction) * brightness * brightness;
        }
    return to;
}

/// What of a place's brightnesses is needed for a direction of light, with basis 1, max(0, g), max(0, -g).
struct Place {
    float u[3] = {0, 0, 0};     ///< sum of w b times basis
    float m[6] = {0, 0, 0, 0, 0, 0};  ///< sum of w times products of basis: 00 01 02 11 12(=0) 22
    float weight = 0;
};

/// What a light explains.
struct Fit {
    double alpha[3] = {1, 0, 0};
    double left = 2;
};

Place placeOf(const Sighting* s, std::size_t views, const float* light) {
    Place p;
    for (std::size_t n = 0; n < views; ++n) {
        const float g = -(s[n].normal[0] * light[0] + s[n].normal[1] * light[1] + s[n].normal[2] * light[2]);
        const float f = std::max(0.0f, g), h = std::max(0.0f, -g), w = s[n].weight, b = s[n].brightness;
        p.weight += w;
        p.u[0] += w * b; p.u[1] += w * b * f; p.u[2] += w * b * h;
        p.m[1] += w * f; p.m[2] += w * h; p.m[3] += w * f * f; p.m[5] += w * h * h;
    }
    p.m[0] = p.weight;
    return p;
}
double env(const char* n, double d) { const char* e = getenv(n); return e ? atof(e) : d; }

Fit fitAll(const Sightings& sightings, const Vec3& light) {
    static const double mu = env("MU", 0.05); static const int iters = int(env("IT", 12)), two = int(env("TWO", 1));
    const float l[3] = {float(light.x), float(light.y), float(light.z)};
    std::vector<Place> places(sightings.all.size() / sightings.views);
    for (std::size_t p = 0; p < places.size(); ++p) places[p] = placeOf(sightings.all.data() + p * sightings.views, sightings.views, l);
    Fit fit; fit.alpha[0] = 0.6; fit.alpha[1] = .4; fit.alpha[2] = 0;
    double mean = 0, W = 0; 
    for (auto& p : places) { mean += p.u[0]; W += p.weight; }
    mean /= W;
    for (int it = 0; it < iters; ++it) {
        double A[3][3] = {}, r[3] = {}, left = sightings.power, cs = 0;
        const double* a = fit.alpha;
        for (auto& p : places) {
            const double au = a[0]*p.u[0]+a[1]*p.u[1]+a[2]*p.u[2];
            const double am = a[0]*a[0]*p.m[0]+2*a[0]*(a[1]*p.m[1]+a[2]*p.m[2])+a[1]*a[1]*p.m[3]+a[2]*a[2]*p.m[5];
            const double c = (au + mu*p.weight*mean)/(am + mu*p.weight);
            left += -2*c*au + c*c*am + mu*p.weight*(c-mean)*(c-mean);
            cs += c*p.weight;
            const double cc = c*c;
            A[0][0]+=cc*p.m[0];A[0][1]+=cc*p.m[1];A[0][2]+=cc*p.m[2];A[1][1]+=cc*p.m[3];A[2][2]+=cc*p.m[5];
            for (int i=0;i<3;++i) r[i]+=c*p.u[i];
        }
        fit.left = left/sightings.power;
        if (it == iters-1) break;
        // coordinate descent with bounds
        double* x = fit.alpha;
        for (int k=0;k<20;++k) {
            x[0] = std::max(0.0,(r[0]-A[0][1]*x[1]-A[0][2]*x[2])/A[0][0]);
            if (A[1][1]>0) x[1] = std::max(0.0,(r[1]-A[0][1]*x[0])/A[1][1]);
            if (two && A[2][2]>0) x[2] = std::min(x[1], std::max(0.0,(r[2]-A[0][2]*x[0])/A[2][2]));
        }
        const double norm = 1/(x[0]+x[1]);
        for (int i=0;i<3;++i) x[i]*=norm;
        mean = cs/W/norm;
    }
    return fit;
}

struct Candidate {
    Vec3 light;
    double left = 2;
};

void improve(Candidate& best, const Candidate& other) {
    if (other.left < best.left) best = other;
}

Candidate tried(const Sightings& sightings, const Vec3& light) { return {light, fitAll(sightings, light).left}; }

/// Smaller and smaller steps.
Candidate refined(const Sightings& sightings, Candidate best) {
    for (double step = 0.12; step > 0.002; step *= 0.5)
        for (bool moved = true; moved;) {
            const Candidate from = best;
            const Vec3 beside = std::abs(from.light.x) < 0.9 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
            const Vec3 u = from.light.cross(beside).normalized(), v = from.light.cross(u);
            for (const Vec3& change : {u, v, u * -1.0, v * -1.0})
                improve(best, tried(sightings, (from.light + change * step).normalized()));
            moved = best.left < from.left;
        }
    return best;
}

/// Evenly over the sphere (render/rig.h).
std::vector<Vec3> evenDirections(int count) {
    std::vector<Vec3> directions;
    for (int i = 0; i < count; ++i) {
        const double z = 1 - (2 * i + 1.0) / count, level = std::sqrt(1 - z * z);
        const double angle = i * kPi * (3 - std::sqrt(5.0));
        directions.push_back({level * std::cos(angle), level * std::sin(angle), z});
    }
    return directions;
}

PhotoLight search(const Sightings& sightings, int count) {
    const std::vector<Vec3> directions = evenDirections(count);
    std::vector<Candidate> all(directions.size());
    parallelFor(all.size(), [&](std::size_t i) { all[i] = tried(sightings, directions[i]); });
    Candidate best = all.front();
    for (const Candidate& one : all) improve(best, one);
    best = refined(sightings, best);
    const double near = std::cos(30 * kPi / 180);
    Candidate aside{{}, 1};
    for (const Candidate& one : all)
        if (one.light.dot(best.light) <= near) improve(aside, one);
    PhotoLight light;
    const Fit fit = fitAll(sightings, best.light);
    if (getenv("SHOW")) printf("alpha %.3f %.3f %.3f\n", fit.alpha[0], fit.alpha[1], fit.alpha[2]);
    light.shading.diffuse = fit.alpha[1] / std::max(fit.alpha[0] + fit.alpha[1], 1e-30);
    light.shading.ambient = 1 - light.shading.diffuse;
    light.shading.light = best.light;
    light.residual = std::sqrt(best.left);
    light.aside = std::sqrt(aside.left);
    light.ambient = std::sqrt(fitAll(sightings, Vec3(0)).left);
    return light;
}

}  // namespace

void PhotoLightOptions::validate() const {
    requireField(resolution >= 8 && resolution <= 256, "resolution of the light's volume", resolution, "from 8 to 256");
    requireField(views > 1, "views for the light", views, "at least 2");
    requireField(passes > 0, "passes for the light", passes, "at least 1");
    requireField(places > 0, "places for the light", places, "at least 1");
    requireField(directions > 1, "directions of the light", directions, "at least 2");
}

PhotoLight findLight(const std::vector<Photograph>& photographs, const ReconstructionGrid& grid,
                     const PhotoLightOptions& options, const ProgressCallback& progress) {
    options.validate();
    const ReconstructionGrid coarse = coarser(grid, options.resolution);
    const std::vector<Photograph> pictures = picturesFor(someOf(photographs, options.views), coarse);
    PhotoSartOptions first;
    first.iterations = options.passes;
    const auto inFirst = [&](const std::string&, double fraction) {
        return report(progress, "looking for the light", fraction);
    };
    ColorVolume volume;
    PhotoLight light;
    light.shading = Shading();
    for (int round = 0; round < env("ROUNDS", 4); ++round) {
        first.light.shading = light.shading;
        if (round) first.iterations = env("MORE", 2);
        PhotoVolumes from; if (round) from.initial = &volume;
        const PhotoReconstruction r = photoSart(pictures, coarse, first, from, inFirst);
        volume.density = r.density; volume.color = r.color;
        Surfaces surfaces = surfacesOf(r, coarse);
        light = search(sightingsOf(pictures, surfaces, first.light.shading, std::size_t(options.places)), options.directions);
        if (getenv("SHOW")) { const Vec3 q = Vec3(.5,.7,-.5).normalized(); printf("round %d off %.2f diffuse %.3f residual %.4f aside %.4f ambient %.4f image %.4f\n", round, acos(std::min(1.0,light.shading.light.dot(q)))*57.2958, light.shading.diffuse, light.residual, light.aside, light.ambient, r.history.back().imageError); fflush(stdout); }
    }
    return light;
}

}  // namespace raysweep
