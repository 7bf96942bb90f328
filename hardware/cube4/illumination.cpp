#include "cube4/illumination.h"

#include "cube4/arithmetic.h"

#include "raysweep/core/require.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace raysweep::cube4 {
namespace {

constexpr double kThinnest = 1e-20, kThickest = 1e6;  ///< mean optical depths: below none, above no more
constexpr int kTableBits = 16;                        ///< of a scalar that address a table, at most

double voxelEdge(const DenseBox& box) {
    return std::cbrt(box.voxelVolume());
}

/// The extinction of a voxel as it counts.
double counting(const DenseMedium& medium, std::size_t i) {
    const double mean = medium.escapeTable()->meanLength();
    const double depth = double(medium.extinction[i]) * mean;
    return depth < kThinnest ? 0.0 : std::min(depth, kThickest) / mean;
}

/// Escape probabilities of voxels; 1 where the rule knows of none.
DenseField escapes(const DenseMedium& medium, ExchangeRule rule) {
    DenseField escape(medium.extinction.size(), 1.0f);
    if (rule == ExchangeRule::asPrinted) return escape;
    for (std::size_t i = 0; i < escape.size(); ++i)
        if (medium.extinction[i] > 0 && !medium.isSurface(i))
            escape[i] = float(medium.escapeTable()->probability(counting(medium, i)));
    return escape;
}

/// Effective albedos, from escape probabilities.
DenseField gains(const DenseMedium& medium, const DenseField& escape) {
    DenseField gain(escape.size());
    for (std::size_t i = 0; i < gain.size(); ++i)
        gain[i] = float(double(medium.albedo[i]) * leavingPart(double(medium.albedo[i]), double(escape[i])));
    return gain;
}

}  // namespace

void IlluminationSetup::validate() const {
    requireField(pipelines >= 1, "pipelines", pipelines, "at least 1");
    requireField(zeta > 0 && zeta <= 1, "zeta", zeta, "in (0,1]");
    requireField(mostShot > 0 && mostShot <= 1, "mostShot", mostShot, "in (0,1]");
    requireField(largestPower > 0 && std::isfinite(largestPower), "largestPower", largestPower, "positive");
    if (format) format->validate();
}

namespace {
enum class Stored { unshot, deposit };
}  // namespace

/// What both kinds of arithmetic have in common for those who do not care.
struct Illumination::Machine {
    virtual ~Machine() = default;
    virtual FrontPower sweep(const SweepFront& front, bool inject, bool group, bool last, Trace* trace) = 0;
    virtual DenseField read(Stored word) const = 0;

    Counters counters;
    std::size_t passes = 0, bytesPerModule = 0, bufferBytes = 0;
    double largestPower = 0;
};

namespace {

template <class Arithmetic>
class MachineOf : public Illumination::Machine {
  public:
    using Word = typename Arithmetic::Word;

    MachineOf(const DenseMedium& medium, const IlluminationSetup& setup, Arithmetic arithmetic)
        : escape_(medium.escapeTable()),
          box_(medium.box),
          setup_(setup),
          arithmetic_(std::move(arithmetic)),
          pad_(setup.resampling == Resampling::linear ? 1 : 0),
          memory_(medium.box.size() + Index3(2 * pad_), setup.pipelines) {
        chooseUnits(medium);
        const DenseField escape = escapes(medium, setup.rule), gain = gains(medium, escape);
        for (Voxel<Word>& voxel : memory_.all()) voxel.escape = Arithmetic::word(1, 1);
        memory_.forEachWithin(pad_, [&](std::size_t i, Voxel<Word>& voxel) {
            voxel.scalar = Arithmetic::word(counting(medium, i), scalarUnit_);
            voxel.gain = Arithmetic::word(double(gain[i]), partUnit_);
            voxel.escape = Arithmetic::word(1 / double(escape[i]), 1);
            for (std::size_t axis = 0; medium.isSurface(i) && axis < 3; ++axis)
                voxel.normal[axis] = medium.normal[axis][i];
            if (!medium.source.empty()) voxel.source = toPower(double(medium.source[i]), "source");
            if (!medium.unshot.empty()) voxel.unshot = toPower(double(medium.unshot[i]), "unshot power");
        });
        bytesPerModule = (memory_.voxelsPerModule() * bitsPerVoxel() + 7) / 8;
    }

    FrontPower sweep(const SweepFront& front, bool inject, bool group, bool last, Trace* trace) override {
        const Vec3 index = front.direction.normalized() * box_.worldFromIndex.inverse();
        const ContentBox content{Index3(pad_), Index3(pad_) + box_.size()};
        const Traversal traversal =
            traverse(memory_.size(), content, {index, front.offsetU, front.offsetV}, setup_.resampling);
        const auto slices = slicesOf(traversal, arithmetic_);
        ExchangeSetup<Word> setup = exchangeSetup(traversal);
        setup.inject = inject;
        setup.group = group;
        setup.settle = last;
        setup.travel = front.direction.normalized();
        RayPlane<Word> entering(traversal, slices);
        const Word power = toPower(front.entering, "power of a ray");
        for (Ray<Word>& ray : entering.rays) ray.value = power;
        PassOptions options;
        options.overlap = setup_.overlap;
        options.trace = trace;
        const PassResult<Word> result =
            runPass(arithmetic_, memory_, {traversal, slices, setup, entering}, setup_.pipelines, options);
        ++passes;
        counters += result.counters;
        bufferBytes = std::max(bufferBytes, ((result.rayWords + result.bufferWords) * bitsPerRay() + 7) / 8);
        FrontPower sums;
        sums.entered = double(result.raysEntered) * double(power) * powerUnit_;
        for (const Ray<Word>& ray : result.leaving.rays) sums.escaped += double(ray.value) * powerUnit_;
        largestPower = std::max(largestPower, double(std::max(power, result.largestRay)) * powerUnit_);
        for (const Voxel<Word>& voxel : memory_.all())
            largestPower = std::max(largestPower, double(voxel.unshot) * powerUnit_);
        return sums;
    }

    DenseField read(Stored word) const override {
        DenseField field(box_.voxels());
        memory_.forEachWithin(pad_, [&](std::size_t i, const Voxel<Word>& voxel) {
            field[i] = float(double(word == Stored::unshot ? voxel.unshot : voxel.deposit) * powerUnit_);
        });
        return field;
    }

  private:
    /// Scalar and effective albedo; source and unshot power; deposit. The escape probability is in a table.
    std::size_t bitsPerVoxel() const {
        if constexpr (Arithmetic::kExact) return 5 * 8 * sizeof(Word);
        const NumberFormat format = setup_.format.value_or(NumberFormat{});
        return std::size_t(format.scalar + format.part + 2 * format.energy + format.sum);
    }
    std::size_t bitsPerRay() const { return setup_.format ? std::size_t(setup_.format->energy) : 8 * sizeof(Word); }

    void chooseUnits(const DenseMedium& medium) {
        if constexpr (!Arithmetic::kExact) {
            const NumberFormat& format = arithmetic_.format();
            const double most = largestOf(medium.extinction);
            const auto largestCode = [](int bits) { return std::ldexp(1.0, bits) - 1; };
            scalarUnit_ = most > 0 ? most / largestCode(format.scalar) : 1;
            powerUnit_ = setup_.largestPower / largestCode(format.energy);
            partUnit_ = std::ldexp(1.0, -format.part);
            format.requireSumsHold(setup_.largestDeposit / powerUnit_, "deposits");
        } else {
            (void)medium;
        }
    }

    /// @throw InvalidArgument if it does not fit
    Word toPower(double value, const char* what) const {
        const Word word = Arithmetic::word(value, powerUnit_);
        if constexpr (!Arithmetic::kExact)
            if (const double times = value / setup_.largestPower; times > 1)
                throw InvalidArgument(std::string("energy words of ") + std::to_string(arithmetic_.format().energy) +
                                      " bits hold powers up to " + std::to_string(setup_.largestPower) + ", and the " +
                                      what + " is " + std::to_string(times) + " times as much");
        return word;
    }

    /// Optical depth, and what is shot, for a scalar of 1 unit.
    ExchangeSetup<Word> exchangeSetup(const Traversal& traversal) const {
        ExchangeSetup<Word> setup;
        const bool printed = setup_.rule == ExchangeRule::asPrinted;
        setup.depth = (printed ? voxelEdge(box_) : traversal.stepLength) * scalarUnit_;
        setup.part = printed ? 1e30 : setup_.zeta;
        setup.most = printed ? std::min(setup_.mostShot, setup_.zeta) : setup_.mostShot;
        setup.printed = printed;
        setup.ofSurface = std::min(setup_.mostShot, printed ? setup_.zeta : 4 * setup_.zeta);
        if constexpr (!Arithmetic::kExact) fillTables(setup);
        return setup;
    }

    void fillTables(ExchangeSetup<Word>& setup) const {
        const int bits = arithmetic_.format().scalar;
        setup.tableShift = std::max(0, bits - kTableBits);
        const EscapeTable& escape = *escape_;
        for (std::size_t entry = 0; entry < std::size_t(1) << (bits - setup.tableShift); ++entry) {
            // The middle of the scalars that share the entry.
            const double scalar = double(entry << setup.tableShift) + 0.5 * (std::ldexp(1.0, setup.tableShift) - 1);
            const double depth = scalar * setup.depth, opacity = -std::expm1(-depth);
            const double p = setup_.rule == ExchangeRule::asPrinted ? 1 : escape.probability(scalar * scalarUnit_);
            const double shot = std::min(setup.part / p * (depth > 0 ? opacity / depth : 1), setup.most);
            setup.opacity.push_back(Arithmetic::word(opacity, partUnit_));
            setup.shot.push_back(Arithmetic::word(shot, partUnit_));
        }
    }

    std::shared_ptr<const EscapeTable> escape_;
    DenseBox box_;
    IlluminationSetup setup_;
    Arithmetic arithmetic_;
    int pad_;
    double scalarUnit_ = 1, powerUnit_ = 1, partUnit_ = 1;
    VoxelMemory<Word> memory_;
};

std::unique_ptr<Illumination::Machine> machineFor(const DenseMedium& medium, const IlluminationSetup& setup) {
    setup.validate();
    if (setup.format) return std::make_unique<MachineOf<FixedPoint>>(medium, setup, FixedPoint(*setup.format));
    return std::make_unique<MachineOf<FloatArithmetic>>(medium, setup, FloatArithmetic());
}

}  // namespace

Illumination::Illumination(const DenseMedium& medium, const IlluminationSetup& setup)
    : machine_(machineFor(medium, setup)) {}
Illumination::~Illumination() = default;
Illumination::Illumination(Illumination&&) noexcept = default;

std::vector<FrontPower> Illumination::sweep(const std::vector<SweepFront>& fronts, bool inject, Trace* trace) {
    std::vector<FrontPower> powers;
    for (std::size_t i = 0; i < fronts.size(); ++i)
        powers.push_back(machine_->sweep(fronts[i], inject, fronts.size() > 1, i + 1 == fronts.size(), trace));
    return powers;
}

DenseField Illumination::deposit() const {
    return machine_->read(Stored::deposit);
}
DenseField Illumination::unshot() const {
    return machine_->read(Stored::unshot);
}
double Illumination::largestPower() const {
    return machine_->largestPower;
}
const Counters& Illumination::counters() const {
    return machine_->counters;
}
std::size_t Illumination::passes() const {
    return machine_->passes;
}
std::size_t Illumination::bytesPerModule() const {
    return machine_->bytesPerModule;
}
std::size_t Illumination::bufferBytes() const {
    return machine_->bufferBytes;
}

DenseField effectiveAlbedo(const DenseMedium& medium, ExchangeRule rule) {
    return gains(medium, escapes(medium, rule));
}

double crossSection(const DenseBox& box, const Vec3& direction) {
    const Vec3 index = direction.normalized() * box.worldFromIndex.inverse();
    return box.voxelVolume() * std::abs(index[majorAxis(index)]);
}

DenseField directDeposit(const DenseMedium& medium, const IlluminationSetup& setup, const Vec3& direction,
                         FrontPower& power) {
    DenseMedium black = medium;
    black.albedo.assign(medium.extinction.size(), 0.0f);
    black.source.clear();
    black.unshot.clear();
    // Nothing is shot that surfaces could shade: they take from all rays, as voxels without a surface do.
    if (setup.rule == ExchangeRule::corrected) black.normal = {};
    IlluminationSetup linear = setup;
    linear.resampling = Resampling::linear;
    Illumination machine(black, linear);
    power = machine.sweep({{direction, 0, 0, 1}}, false).front();
    return machine.deposit();
}

DenseField radiosity(const DenseMedium& medium, const IlluminationSetup& setup, const DenseField& deposit,
                     int injections) {
    const DenseField escape = escapes(medium, setup.rule), gain = gains(medium, escape);
    const double volume = medium.box.voxelVolume(), edge = voxelEdge(medium.box);
    const bool printed = setup.rule == ExchangeRule::asPrinted;
    const double meanInverse = medium.escapeTable()->meanInverseLength();
    DenseField radiosity(deposit.size(), 0.0f);
    for (std::size_t i = 0; i < deposit.size(); ++i) {
        const double extinction = counting(medium, i);
        if (!(extinction > 0) || medium.isSurface(i)) continue;
        const double absorbs =
            printed ? -std::expm1(-extinction * edge) * volume * meanInverse : extinction * volume * double(escape[i]);
        const double source = medium.source.empty() ? 0 : double(medium.source[i]);
        radiosity[i] = float((source + double(gain[i]) * double(deposit[i]) / injections) / (4 * kPi * absorbs));
    }
    return radiosity;
}

}  // namespace raysweep::cube4
