#include "plain_exchange.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <utility>

#include "raysweep/sweep/directions.h"

namespace raysweep::test {
namespace {

BrickLayout smallLayout() {
    BrickLayout layout;  // with a hole, and in more than one quadrant
    layout.origins = {{-8, 0, 0}, {-8, 8, 8}, {0, 0, 0}, {0, 0, 8}, {0, 8, 0}, {8, -8, 0}};
    layout.low = Index3(-8, -8, 0);
    layout.high = Index3(16, 16, 16);
    return layout;
}

/// A beam and what it shares with the others of its sweep.
struct PlainBeam : ExchangeConstants {
    PlainBeam(const ExchangeConstants& constants, const Beam& ofBeam) : ExchangeConstants(constants), beam(ofBeam) {}
    const Beam& beam;
};

double cosineOf(const PlainBeam& plain, PackedNormal normal) {
    return unpackNormal(normal).dot(plain.beam.front.direction);
}

/// What the formulas say about one voxel.
struct VoxelTerms {
    double opacity, shot, g;
};

VoxelTerms termsOf(const PlainBeam& plain, PackedNormal normal, double tau, double albedo) {
    const double along = tau * double(plain.beam.stepScale), opacity = -std::expm1(-along);
    if (isSurface(normal)) {
        const double cosine = cosineOf(plain, normal);
        const bool paper = plain.model == ExchangeModel::asPrinted;
        const double shot = paper ? double(plain.zeta) : std::min(double(plain.mostShot), 4 * double(plain.zeta));
        if (cosine > 0) return {plain.direct && !paper ? opacity : 0, shot * std::min(1.0, cosine), albedo};
        return {opacity * (paper ? std::min(1.0, -cosine) : 1), 0, albedo};
    }
    if (plain.model == ExchangeModel::asPrinted) return {opacity, double(plain.zeta), albedo};
    const double p = plain.escape.probability(tau);
    const double ratio = along > 0 ? opacity / along : 1;
    return {opacity, std::min(double(plain.mostShot), double(plain.zeta) * ratio / p),
            albedo * leavingShare(albedo, p)};
}

/// The local furnace in doubles, by its definition in exchange.h.
struct PlainFurnace {
    struct Ray {
        double f = 0;
        int last = -1000000;  ///< slice in which it was in a solid
        double taken = 0, inside = 0;
    };
    std::map<std::pair<int, int>, Ray> rays;

    /// What a voxel takes of a ray that meets it with `weight` in slice k.
    void meet(const PlainBeam& plain, const std::pair<int, int>& at, int k, PackedNormal normal, double tau,
              double opacity, double weight, double& total) {
        Ray& ray = rays[at];
        if (ray.last < k - kSurfaceGap) ray.f = double(plain.beam.furnaceRay);
        const bool leaving = isSurface(normal) && tau > 0 && cosineOf(plain, normal) > double(kLeavingCosine);
        const bool inside = !leaving && normal != 0 && tau > 0;
        const double in = inside ? weight * opacity * ray.f : 0;
        total += in;
        ray.taken += in;
        ray.inside += weight * (inside ? 1 : leaving ? -1 : 0);
    }
    void endSlice(int k) {
        for (auto& [at, ray] : rays) {
            ray.f = std::max(0.0, ray.f - ray.taken);
            if (ray.inside != 0) ray.last = ray.inside > 0 ? k : -1000000;
            ray.taken = ray.inside = 0;
        }
    }
};

/// A sweep in doubles, of one channel: slices in the order of travel, rays in a map. `nearest` has one footprint of
/// weight 1.
struct PlainSweep {
    const ExchangeVolume& volume;
    const PlainBeam& plain;
    int channel;
    PlainField& unshot;
    PlainField& deposit;
    PlainField& furnaceDeposit;
    const RayFront& front = plain.beam.front;
    const BrickMap map = BrickMap(volume.sweepVolume.layout);
    std::map<std::pair<int, int>, double> rays = {};
    PlainFurnace furnace = {};

    /// @return power that escapes
    double run() {
        const RayRange rows = rayExtent(front, front.row);
        for (int r = rows.begin; r < rows.end; ++r) {
            const RayRange columns = raysThatEnter(front, r);
            for (int c = columns.begin; c < columns.end; ++c) rays[{r, c}] = double(plain.beam.entering[channel]);
        }
        for (int k = 0; k < front.slices; ++k) goThroughSlice(k);
        double escaped = 0;
        for (const auto& [at, ray] : rays) escaped += ray;
        return escaped;
    }

    void goThroughSlice(int k) {
        const BrickLayout& layout = volume.sweepVolume.layout;
        std::map<std::pair<int, int>, double> change;
        Index3 voxel;
        voxel[front.axis.major] = front.ascending ? front.firstSlice + k : front.firstSlice - k;
        for (int v = layout.low[front.axis.row]; v < layout.high[front.axis.row]; ++v)
            for (int u = layout.low[front.axis.column]; u < layout.high[front.axis.column]; ++u) {
                voxel[front.axis.row] = v;
                voxel[front.axis.column] = u;
                if (map.find(voxel) != kNoBrick) exchangeVoxel(k, voxel, change);
            }
        for (const auto& [ray, delta] : change) rays[ray] += delta;
        furnace.endSlice(k);
    }

    void exchangeVoxel(int k, const Index3& voxel, std::map<std::pair<int, int>, double>& change) {
        const std::size_t b = map.find(voxel), i = offsetInBrick(voxel), at = b * kBrickVoxels + i;
        const PackedNormal* const normals = volume.surfaces.normals(b);
        const double tau = double(volume.tau.brick(b)[i]);
        const VoxelTerms terms =
            termsOf(plain, normals ? normals[i] : 0, tau, double(volume.albedo[channel].brick(b)[i]));
        const double out = double(volume.unshot[channel].brick(b)[i]) * terms.shot;
        double in = 0;
        for (int dv = 0; dv <= front.reach; ++dv)
            for (int du = 0; du <= front.reach; ++du) {
                const double weight = upperPart(front.row, k, dv) * upperPart(front.column, k, du);
                const std::pair<int, int> ray{rayAt(front.row, k, voxel[front.axis.row] - dv),
                                              rayAt(front.column, k, voxel[front.axis.column] - du)};
                const double taken = weight * terms.opacity * rays[ray];
                in += taken;
                if (normals)
                    furnace.meet(plain, ray, k, normals[i], tau, terms.opacity, weight,
                                 furnaceDeposit[volume.surfaces.slots[b] * std::size_t(kBrickVoxels) + i]);
                change[ray] += weight * out - taken;
            }
        deposit[at] = in;
        unshot[at] = terms.g * in - out + double(volume.source[channel].brick(b)[i]);
    }

    /// Weight of the lower (0) or upper (1) of two neighbours along a lateral axis.
    double upperPart(const Lateral& lateral, int k, int upper) const {
        if (front.reach == 0) return 1;
        const double part = lateral.position(k) - lateral.shift(k);
        return upper ? part : 1 - part;
    }

    /// Lattice coordinate of the ray that is at `voxel` in slice k.
    static int rayAt(const Lateral& lateral, int k, int voxel) {
        const int ray = voxel - lateral.shift(k);
        if (!lateral.periodic) return ray;
        const int past = (ray - lateral.low) % lateral.size();
        return lateral.low + (past < 0 ? past + lateral.size() : past);
    }
};

}  // namespace

ExchangeVolume::ExchangeVolume(const ExchangeCase& made)
    : channels(made.channels), sweepVolume(smallLayout(), made.periodic), escape(Matrix3()) {
    std::mt19937_64 random(11);
    const std::size_t bricks = sweepVolume.layout.brickCount();
    const auto fill = [&](BrickField& field, double low, double high) {
        field = BrickField(bricks);
        for (std::size_t b = 0; b < bricks; ++b)
            for (int i = 0; i < kBrickVoxels; ++i)
                field.brick(b)[i] = float(low * std::pow(high / low, uniform01(random)));
    };
    fill(tau, 1e-4, made.thickest);
    for (std::size_t b = 0; b < bricks; ++b) tau.brick(b)[17] = 0;
    // Some voxels are surfaces and some are inside, in some bricks.
    const std::vector<Vec3> ways = sphericalFibonacci(64);
    for (std::size_t b = 0; b < bricks; b += 2) {
        PackedNormal* const normals = made.surfaces ? addSurfaceBrick(surfaces, bricks, b) : nullptr;
        for (int i = 0; i < kBrickVoxels; ++i) {
            const double kind = uniform01(random);
            if (normals)
                normals[i] = kind < 0.3 ? packNormal(ways[std::size_t(i) % 64]) : kind < 0.5 ? kInsideSolid : 0;
        }
    }
    furnace = BrickField(surfaces.bricks.size());
    for (int c = 0; c < channels; ++c) {
        fill(albedo[c], 0.1, 1);
        fill(source[c], 1e-3, 0.1);
        fill(unshot[c], 0.01, 1);
        fill(deposit[c], 0.1, 1);
        fresh[c] = BrickField(bricks);
    }
}

ExchangeFields ExchangeVolume::fields() {
    ExchangeFields views;
    views.channels = channels;
    if (!surfaces.empty()) {
        views.surfaces = &surfaces;
        views.furnace = viewOf(furnace);
    }
    views.tau = viewOf(tau);
    for (int c = 0; c < channels; ++c) {
        views.albedo[c] = viewOf(albedo[c]);
        views.source[c] = viewOf(source[c]);
        views.unshot[c] = viewOf(unshot[c]);
        views.deposit[c] = viewOf(deposit[c]);
        views.fresh[c] = viewOf(fresh[c]);
    }
    return views;
}

void ExchangeVolume::restore(const ExchangeVolume& before) {
    const auto copy = [](const BrickField& from, BrickField& to) {
        std::copy_n(from.brick(0), from.brickCount() * kBrickVoxels, to.brick(0));
    };
    if (!surfaces.empty()) copy(before.furnace, furnace);
    for (int c = 0; c < channels; ++c) {
        copy(before.unshot[c], unshot[c]);
        copy(before.deposit[c], deposit[c]);
        copy(before.fresh[c], fresh[c]);
    }
}

PlainChange plainSweep(const ExchangeVolume& volume, const ExchangeConstants& constants, const Beam& beam) {
    const PlainBeam plain(constants, beam);
    const std::size_t voxels = volume.sweepVolume.layout.brickCount() * kBrickVoxels;
    PlainChange change;
    for (int c = 0; c < volume.channels; ++c) {
        change.unshot[c].assign(voxels, 0.0);
        change.deposit[c].assign(voxels, 0.0);
        change.furnace.assign(volume.surfaces.bricks.size() * kBrickVoxels, 0.0);  // the same in every channel
        PlainSweep sweep{volume, plain, c, change.unshot[c], change.deposit[c], change.furnace};
        change.escaped[c] = sweep.run();
    }
    return change;
}

}  // namespace raysweep::test
