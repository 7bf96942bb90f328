#include "hardware/random_box.h"

#include <cmath>
#include <utility>

#include "cube4/arithmetic.h"
#include "support/worst.h"

namespace raysweep::test {
namespace {

BrickLayout boxLayout(const Index3& bricks) {
    BrickLayout layout;
    for (int x = 0; x < bricks.x; ++x)
        for (int y = 0; y < bricks.y; ++y)
            for (int z = 0; z < bricks.z; ++z) layout.origins.push_back(Index3(x, y, z) * kBrickEdge);
    layout.high = bricks * kBrickEdge;
    layout.worldFromIndex.makeIdentity();
    layout.activeVoxels = layout.brickCount() * kBrickVoxels;
    return layout;
}

}  // namespace

template <class Visit>
void RandomBox::forEachVoxel(const Visit& visit) const {
    for (std::size_t b = 0; b < layout_.brickCount(); ++b)
        for (int i = 0; i < kBrickVoxels; ++i)
            visit(b, i, layout_.origins[b] + Index3(i >> 6, (i >> 3) & 7, i & 7) + Index3(pad_));
}

RandomBox::RandomBox(const Index3& bricks, int pipelines, int pad, cube4::Skew skew)
    : layout_(boxLayout(bricks)),
      pipelines_(pipelines),
      pad_(pad),
      memory_(layout_.high + Index3(2 * pad), pipelines, skew),
      tau_(layout_.brickCount()),
      albedo_(layout_.brickCount()),
      source_(layout_.brickCount()),
      unshot_(layout_.brickCount()),
      deposit_(layout_.brickCount()),
      fresh_(layout_.brickCount()) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> uniform(0, 1);
    for (cube4::Voxel<float>& voxel : memory_.all()) voxel.escape = 1;
    forEachVoxel([&](std::size_t b, int i, const Index3& at) {
        cube4::Voxel<float>& voxel = memory_.at(at);
        const bool empty = uniform(random) < 0.2f;
        tau_.brick(b)[i] = voxel.scalar = empty ? 0 : 2 * uniform(random);
        albedo_.brick(b)[i] = voxel.gain = uniform(random);
        source_.brick(b)[i] = voxel.source = 0.1f * uniform(random);
        unshot_.brick(b)[i] = voxel.unshot = uniform(random);
    });
}

RaySums RandomBox::sweep(const Vec3& direction, const LatticeOffset& offset, float zeta) {
    Beam beam;
    beam.front = parallelFront(layout_, direction, pad_, offset, {false, false, false});
    beam.entering[0] = kEntering;
    ExchangeFields fields;
    fields.tau = viewOf(std::as_const(tau_));
    fields.albedo[0] = viewOf(std::as_const(albedo_));
    fields.source[0] = viewOf(std::as_const(source_));
    fields.unshot[0] = viewOf(unshot_);
    fields.deposit[0] = viewOf(deposit_);
    fields.fresh[0] = viewOf(fresh_);
    ExchangeConstants constants;
    constants.model = ExchangeModel::asPrinted;
    constants.zeta = zeta;
    const SweepVolume volume(layout_);
    const Interpolation interpolation = pad_ > 0 ? Interpolation::linear : Interpolation::nearest;
    const RaySums sums = raysweep::sweep(volume, {beam}, interpolation, fields, constants)[0];
    if (pad_ > 0) settle(volume, {beam}, fields, constants);
    return sums;
}

cube4::PassResult<float> RandomBox::pass(const Vec3& direction, const LatticeOffset& offset, float zeta,
                                         const cube4::PassOptions& options) {
    using namespace cube4;
    const FloatArithmetic arithmetic;
    const Traversal traversal = traverse(memory_.size(), {Index3(pad_), Index3(pad_) + layout_.high},
                                         {direction.normalized(), offset.column, offset.row},
                                         pad_ > 0 ? Resampling::linear : Resampling::nearest);
    const auto slices = slicesOf(traversal, arithmetic);
    ExchangeSetup<float> setup;
    setup.part = 1e30;  // the algorithm as printed shoots the same part of all voxels
    setup.most = double(zeta);
    setup.inject = true;
    RayPlane<float> entering(traversal, slices);
    for (Ray<float>& ray : entering.rays) ray.value = kEntering;
    return runPass(arithmetic, memory_, {traversal, slices, setup, entering}, pipelines_, options);
}

double RandomBox::worst(const BrickField& theirs, float cube4::Voxel<float>::*ours) const {
    double worst = 0, largest = 0;
    forEachVoxel([&](std::size_t b, int i, const Index3& at) {
        const double their = double(theirs.brick(b)[i]);
        raiseTo(worst, std::abs(double(memory_.at(at).*ours) - their));
        raiseTo(largest, their);
    });
    return worst / largest;
}

double RandomBox::worstUnshot() const {
    return worst(unshot_, &cube4::Voxel<float>::unshot);
}

double RandomBox::worstDeposit() const {
    return worst(deposit_, &cube4::Voxel<float>::deposit);
}

}  // namespace raysweep::test
