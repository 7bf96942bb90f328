#include "raysweep/illuminate/estimate.h"

#include "raysweep/core/parallel.h"
#include "raysweep/illuminate/surface_radiosity.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

/// F / (4 pi) in the paper's exchange: a fixed opacity times the mean cross-section of a ray. World area.
double paperAbsorbingArea(const SolverState& state, double tau) {
    const double volume = state.volume.layout.voxelVolume, meanLength = state.escape.meanStepLength();
    const double opacity = -std::expm1(-tau * std::cbrt(volume) / meanLength);
    return opacity * volume / meanLength * state.escape.meanInverseLength();
}

}  // namespace

void absorbingAreas(const SolverState& state, std::size_t b, float* area) {
    const float* const tau = state.tau.brick(b);
    const EscapeFit& fit = state.escape.fit();
    if (state.exchange == ExchangeModel::paper) {
        for (int i = 0; i < kBrickVoxels; ++i) area[i] = float(paperAbsorbingArea(state, double(tau[i])));
        return;
    }
    // In floats, and nothing called: compilers make wide instructions of it.
    const float perDepth = float(state.volume.layout.voxelVolume / state.escape.meanStepLength());
    for (int i = 0; i < kBrickVoxels; ++i) {
        const float t = tau[i];
        const float numerator = 1 + t * (fit.b[0] + t * (fit.b[1] + t * fit.b[2]));
        const float denominator = 1 + t * (fit.a[0] + t * (fit.a[1] + t * (fit.a[2] + t * fit.a[3])));
        area[i] = t * perDepth * (numerator / denominator);
    }
}

namespace {

/// Mean furnace deposit of a sweep in a voxel of a flat wall: 1/(4 pi) times the integral of the cosine.
constexpr double kFlatWall = 0.25;
/// Surface voxels that collect less than this part of a flat wall's are buried, or hardly there: their radiosity would
/// be a ratio of next to nothing and next to nothing.
constexpr double kLeastSeen = 0.02;

/// Source radiance of the voxels of a brick, in `radianceUnit`.
class BrickRadiance {
  public:
    /// @param exact p from the table, not from the quicker fit
    BrickRadiance(const SolverState& state, int channel, std::size_t b, bool exact)
        : state_(state),
          b_(b),
          exact_(exact),
          normals_(state.surfaces.normals(b)),
          tau_(state.tau.brick(b)),
          source_(state.hasSource() ? state.source[channel].brick(b) : state.zero.brick(0)) {
        effectiveAlbedos(state, channel, b, g_);
        findPerPower();
        if (!state.furnace.empty()) solidTau_ = state.solidTau();
        if (!normals_) return;
        const std::uint32_t slot = state.surfaces.slots[b];
        if (!state.furnace.empty()) furnace_ = state.furnace.brick(slot);
        leastFurnace_ = kLeastSeen * kFlatWall * state.injections;
        if (!state.hasSource()) return;
        seen_ = state.seen[channel].brick(slot);
        emitted_ = state.emitted[channel].brick(slot);
    }

    bool isKnown(int i) const {
        if (!(tau_[i] > 0)) return false;
        if (!isSurface(i)) return double(tau_[i]) < solidTau_;
        // Fog where a quad light is has no say of its own.
        return state_.solids && (!furnace_ || double(furnace_[i]) > leastFurnace_);
    }

    bool isSurface(int i) const { return normals_ && normals_[i] != 0; }

    /// 1 / F, in units of 1 / voxelFace. Without sweeps F of a surface is taken to be that of a flat wall.
    double perPower(int i) const {
        if (isSurface(i) && furnace_) return furnace_[i] > 0 ? state_.injections / (4 * kPi * double(furnace_[i])) : 0;
        if (isSurface(i)) return 1 / kPi;
        return double(perPower_[i]);
    }

    /// The part that comes straight from sources. @param perPower of the voxel
    double directly(int i, double perPower) const {
        if (!isSurface(i)) return double(source_[i]) * perPower;
        return seen_ ? double(seen_[i]) + double(emitted_[i]) * perPower : 0;
    }

    /// The part that is scattered of the radiance that the voxel has met: its deposit over F.
    double scattered(int i, double met) const { return double(g_[i]) * met; }

  private:
    /// Of all voxels, taken to be medium; of no meaning in empty ones.
    void findPerPower() {
        const double face = state_.voxelFace() / (4 * kPi);
        if (!exact_) {
            absorbingAreas(state_, b_, perPower_);
            for (float& value : perPower_) value = float(face) / value;
            return;
        }
        const bool paper = state_.exchange == ExchangeModel::paper;
        const double perDepth = face * state_.escape.meanStepLength() / state_.volume.layout.voxelVolume;
        for (int i = 0; i < kBrickVoxels; ++i) {
            const double tau = double(tau_[i]);
            perPower_[i] = float(paper ? face / paperAbsorbingArea(state_, tau)
                                       : perDepth * state_.escape.inverseProbability(tau) / tau);
        }
    }

    const SolverState& state_;
    const std::size_t b_;
    const bool exact_;
    const PackedNormal* const normals_;
    const float* const tau_;
    const float* const source_;
    const float* seen_ = nullptr;
    const float* emitted_ = nullptr;
    const float* furnace_ = nullptr;
    double solidTau_ = INFINITY;
    double leastFurnace_ = 0;
    alignas(64) float g_[kBrickVoxels];
    alignas(64) float perPower_[kBrickVoxels];
};

/// Sums over a brick for the relative RMS difference.
struct Squares {
    double difference = 0, value = 0;
    Squares& operator+=(const Squares& other) {
        difference += other.difference;
        value += other.value;
        return *this;
    }
};

/// total += recent, and what rounding took from the sum stays in recent: a million sweeps lose nothing. Rounded down,
/// so that recent stays >= 0.
void foldVoxel(float& total, float& recent) {
    float sum = total + recent;
    if (sum - total > recent) sum = std::nextafter(sum, 0.0f);
    recent = std::max(0.0f, recent - (sum - total));
    total = sum;
}

Squares foldBrick(SolverState& state, std::size_t b, int before) {
    const double now = 1.0 / state.injections, then = before > 0 ? 1.0 / before : 0;
    Squares sum;
    for (int c = 0; c < state.channels; ++c) {
        const BrickRadiance radiance(state, c, b, /*exact=*/false);
        float* const total = state.total[c].brick(b);
        float* const recent = state.recent[c].brick(b);
        for (int i = 0; i < kBrickVoxels; ++i) {
            if (radiance.isKnown(i)) {
                const double deposit = double(total[i]) + double(recent[i]);
                const double perPower = radiance.perPower(i);
                const double value = radiance.directly(i, perPower) + radiance.scattered(i, deposit * now * perPower);
                const double change = radiance.scattered(i, (deposit * now - double(total[i]) * then) * perPower);
                sum.value += value * value;
                sum.difference += change * change;
            }
            foldVoxel(total[i], recent[i]);
        }
    }
    return sum;
}

/// Deposit over F in the surfaces' bricks.
template <class DepositOf>
BrickField metBySurfaces(const SolverState& state, int channel, const DepositOf& depositOf) {
    BrickField met(state.surfaces.bricks.size());
    parallelFor(state.volume.layout.brickCount(), [&](std::size_t b) {
        if (!state.surfaces.normals(b)) return;
        const BrickRadiance radiance(state, channel, b, /*exact=*/true);
        float* const to = met.brick(state.surfaces.slots[b]);
        for (int i = 0; i < kBrickVoxels; ++i)
            if (radiance.isSurface(i) && radiance.isKnown(i)) to[i] = float(depositOf(b, i) * radiance.perPower(i));
    });
    return met;
}

}  // namespace

void foldDeposits(SolverState& state) {
    parallelFor(
        state.volume.layout.brickCount(),
        [&](std::size_t b) {
            for (int c = 0; c < state.channels; ++c)
                for (int i = 0; i < kBrickVoxels; ++i)
                    foldVoxel(state.total[c].brick(b)[i], state.recent[c].brick(b)[i]);
        },
        16);
}

double foldDeposits(SolverState& state, int sweeps) {
    const Squares sum = orderedSum<Squares>(
        state.volume.layout.brickCount(), [&](std::size_t b) { return foldBrick(state, b, state.injections - sweeps); },
        16);
    return sum.value > 0 ? std::sqrt(sum.difference / sum.value) : 0;
}

ChannelPower unshotPower(const SolverState& state) {
    ChannelPower power;
    for (int c = 0; c < state.channels; ++c) power.value[c] = sumOf(state.unshot[c]);
    return power;
}

PowerBalance balance(const SolverState& state) {
    const bool swept = state.injections > 0;
    // What sweeps deposited, less what of it is scattered on, is absorbed.
    const ChannelPower absorbed =
        orderedSum<ChannelPower>(swept ? state.volume.layout.brickCount() : 0, [&](std::size_t b) {
            ChannelPower sum;
            alignas(64) float g[kBrickVoxels];
            for (int c = 0; c < state.channels; ++c) {
                effectiveAlbedos(state, c, b, g);
                for (int i = 0; i < kBrickVoxels; ++i)
                    sum.value[c] +=
                        (double(state.total[c].brick(b)[i]) + double(state.recent[c].brick(b)[i])) * (1 - double(g[i]));
            }
            return sum;
        });
    // Without a sweep the source is what is still unshot.
    const ChannelPower unshot = unshotPower(state);
    const double perInjection = state.powerUnit / std::max(1, state.injections);
    PowerBalance result;
    for (int c = 0; c < state.channels; ++c) {
        double left = unshot.value[c] * perInjection;
        if (!swept && state.hasSource()) left = state.powerUnit * sumOf(state.source[c]);
        result.injected[c] = state.perInjection.injected[c] * state.powerUnit + state.swept.injected[c] * perInjection;
        result.escaped[c] = state.perInjection.escaped[c] * state.powerUnit + state.swept.escaped[c] * perInjection;
        result.absorbed[c] = state.perInjection.absorbed[c] * state.powerUnit + absorbed.value[c] * perInjection;
        result.unshot[c] = left;
    }
    return result;
}

double PowerBalance::error() const {
    double worst = 0;
    for (int c = 0; c < kMaxChannels; ++c)
        if (injected[c] > 0)
            worst = std::max(worst, std::abs(injected[c] - absorbed[c] - escaped[c] - unshot[c]) / injected[c]);
    return worst;
}

void computeRadiosity(const SolverState& state, int channel, const BrickField& extra, BrickField& radiosity) {
    const std::size_t bricks = state.volume.layout.brickCount();
    const double perInjection = 1.0 / std::max(1, state.injections);
    const bool swept = !state.total[channel].empty();
    const auto depositOf = [&](std::size_t b, int i) {
        double deposit =
            swept ? double(state.total[channel].brick(b)[i]) + double(state.recent[channel].brick(b)[i]) : 0;
        if (!extra.empty()) deposit += double(extra.brick(b)[i]);
        return deposit * perInjection;
    };
    const BrickField even =
        state.furnace.empty() ? BrickField() : evenedOut(state, metBySurfaces(state, channel, depositOf));
    const double unit = state.radianceUnit();
    parallelFor(
        bricks,
        [&](std::size_t b) {
            const BrickRadiance radiance(state, channel, b, /*exact=*/true);
            for (int i = 0; i < kBrickVoxels; ++i) {
                float& S = radiosity.brick(b)[i];
                if (!radiance.isKnown(i)) {
                    S = kUnknown;
                    continue;
                }
                const double perPower = radiance.perPower(i);
                const double met = radiance.isSurface(i) && !even.empty()
                                       ? double(even.brick(state.surfaces.slots[b])[i])
                                       : depositOf(b, i) * perPower;
                S = float((radiance.scattered(i, met) + radiance.directly(i, perPower)) * unit);
            }
        },
        16);
    fillSolids(state, radiosity);
}

}  // namespace raysweep
