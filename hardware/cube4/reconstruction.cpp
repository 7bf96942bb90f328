#include "cube4/reconstruction.h"

#include "cube4/arithmetic.h"
#include "cube4/cone_warp.h"
#include "cube4/reconstruction_units.h"
#include "cube4/region_bound.h"

#include "raysweep/core/error.h"
#include "raysweep/core/require.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace raysweep::cube4 {
namespace {

/// Rays that meet less of the volume than this part of a voxel have no say: their mean would be noise.
constexpr double kLeastLength = 1e-3;
constexpr int kPad = 1;  ///< voxels around the volume that rays beside it are interpolated with

}  // namespace

struct Reconstruction::Machine {
    virtual ~Machine() = default;
    virtual double update(const MeasuredView& view, double relaxation, Trace* trace) = 0;
    virtual std::vector<float> project(const MeasuredView& view) = 0;
    virtual double update(const MeasuredCone& view, double relaxation, Trace* trace) = 0;
    virtual std::vector<float> project(const MeasuredCone& view) = 0;
    virtual DenseField volume() const = 0;

    Counters projecting, backprojecting;
    std::size_t bytesPerModule = 0, bufferBytes = 0;
    double largestValue = 0, largestCorrection = 0;
    Ray<double> largestSums;
};

namespace {

template <class Arithmetic>
class MachineOf : public Reconstruction::Machine {
  public:
    using Word = typename Arithmetic::Word;
    using Weight = typename Arithmetic::Weight;

    MachineOf(const DenseBox& box, const Vec3& origin, const ReconstructionSetup& setup, Arithmetic arithmetic)
        : box_(box),
          origin_(origin),
          setup_(setup),
          arithmetic_(std::move(arithmetic)),
          units_(arithmetic_, setup_),
          memoryBox_{box, origin, kPad},
          memory_(memoryBox_.size(), setup.pipelines) {
        bytesPerModule = bytesOfModule(0);
    }

    void load(const DenseField& initial, const DenseField& support) {
        memory_.forEachWithin(kPad, [&](std::size_t i, Voxel<Word>& voxel) {
            voxel.scalar = initial.empty() ? Word{} : Arithmetic::word(clamped(double(initial[i])), units_.value);
            voxel.gain = support.empty() || support[i] > 0 ? Arithmetic::word(1, units_.weight) : Word{};
        });
    }

    double update(const MeasuredView& view, double relaxation, Trace* trace) override {
        const Front front = frontOf(view);
        const RayPlane<Word> sums = run(front, Pass::project, 0, RayPlane<Word>(front.traversal, front.slices), trace);
        noteLargest(sums);
        RayPlane<Word> corrections = sums;
        forEachRay(front, sums, [&](int u, int v, const Ray<Word>& sum, const Imath::V2d& pixel) {
            Ray<Word>& ray = corrections.at(u, v);
            const double measured = double(sampleOf(view.values, view.width, view.height, pixel));
            const double change = correctionOf(double(sum.value) * front.traversal.stepLength,
                                               double(sum.weight) * front.traversal.stepLength, measured);
            ray = std::isnan(change) ? Ray<Word>{}
                                     : Ray<Word>{units_.correctionWord(change), Arithmetic::word(1, units_.weight)};
        });
        run(front, Pass::backproject, relaxation, corrections, trace);
        return finishedUpdate();
    }

    double update(const MeasuredCone& view, double relaxation, Trace* trace) override {
        const std::vector<PerspectiveFront> fronts = conesOf(view.rays);
        std::vector<RayPlane<Word>> changes;
        for (const PerspectiveFront& front : fronts)
            changes.push_back(corrections(projected(front, trace), front, view));
        for (std::size_t n = 0; n < fronts.size(); ++n)
            backproject(fronts[n], std::move(changes[n]), relaxation, {fronts.size() > 1, n + 1 == fronts.size()});
        return finishedUpdate();
    }

    std::vector<float> project(const MeasuredCone& view) override {
        std::vector<float> picture(std::size_t(view.rays.width) * std::size_t(view.rays.height), 0.0f);
        for (const PerspectiveFront& front : conesOf(view.rays)) {
            const RayPlane<Word> sums = projected(front, nullptr);
            forEachPixel(view.rays, memoryBox_, front, [&](std::size_t pixel, const Imath::V2d& ray, double length) {
                picture[pixel] =
                    float(LatticePoint(sums, ray).interpolated(sums.rays, valueOf) * units_.value * length);
            });
        }
        return picture;
    }

    std::vector<float> project(const MeasuredView& view) override {
        const Front front = frontOf(view);
        const RayPlane<Word> sums =
            run(front, Pass::project, 0, RayPlane<Word>(front.traversal, front.slices), nullptr);
        std::vector<float> lattice;
        for (const Ray<Word>& sum : sums.rays)
            lattice.push_back(float(double(sum.value) * units_.value * front.traversal.stepLength));
        std::vector<float> picture;
        const LatticeShift shiftU = latticeShift(front.traversal, 0, 0), shiftV = latticeShift(front.traversal, 1, 0);
        for (int row = 0; row < view.height; ++row)
            for (int column = 0; column < view.width; ++column) {
                const Imath::V2d at = front.plane.positionOf(front.traversal, column, row, 0);
                const Imath::V2d ray(at.x - shiftU.shift - shiftU.fraction - sums.lowU,
                                     at.y - shiftV.shift - shiftV.fraction - sums.lowV);
                picture.push_back(sampleOf(lattice, sums.width, sums.height, {snapped(ray.x), snapped(ray.y)}));
            }
        return picture;
    }

    DenseField volume() const override {
        DenseField field(box_.voxels());
        memory_.forEachWithin(kPad, [&](std::size_t i, const Voxel<Word>& voxel) {
            field[i] = float(double(voxel.scalar) * units_.value);
        });
        return field;
    }

  private:
    /// A view's rays in the machine.
    struct Front {
        BasePlane plane;
        Traversal traversal;
        std::vector<SliceSetup<Weight>> slices;
    };

    Front frontOf(const MeasuredView& view) const {
        const ContentBox content{Index3(kPad), Index3(kPad) + box_.size()};
        const BasePlane plane(view.rays, box_, origin_, kPad, content);
        const Traversal traversal = traverse(memory_.size(), content, plane.direction(), Resampling::linear);
        return {plane, traversal, slicesOf(traversal, arithmetic_)};
    }

    /// Fronts of a cone's rays. The last one passes all voxels: it is the one in which corrections are made.
    std::vector<PerspectiveFront> conesOf(const PointRays& rays) const {
        std::vector<PerspectiveFront> fronts = frontsOf(rays, memoryBox_, setup_.sampling);
        const auto whole = std::stable_partition(fronts.begin(), fronts.end(), [&](const PerspectiveFront& front) {
            return front.regions.front().first > 0 || front.regions.back().end < box_.size()[front.major];
        });
        if (!fronts.empty() && whole == fronts.end())
            throw InvalidArgument("an X-ray source is in the volume, or less than a voxel from it");
        return fronts;
    }

    RayPlane<Word> projected(const PerspectiveFront& front, Trace* trace) {
        return passRegions(
            bound(projecting), {front, memoryBox_}, planeOf<Word>(front.rangeAt(front.regions.front().level)),
            [&](const RegionPass<Weight>& pass, const RayPlane<Word>& entering) {
                return run({pass.traversal, pass.slices}, exchangeSetup(Pass::project, 0), entering, trace);
            });
    }

    /// Corrections of a lattice's rays from their sums. The sums are interpolated to the pixels, whose corrections are
    /// spread by the same weights, and by the lengths of their rays, as Aᵀ has it.
    RayPlane<Word> corrections(const RayPlane<Word>& sums, const PerspectiveFront& front, const MeasuredCone& view) {
        noteLargest(sums);
        std::vector<double> values(sums.rays.size(), 0.0), weights(sums.rays.size(), 0.0);
        forEachPixel(view.rays, memoryBox_, front, [&](std::size_t pixel, const Imath::V2d& ray, double length) {
            const LatticePoint point(sums, ray);
            const double change =
                correctionOf(point.interpolated(sums.rays, valueOf) * length,
                             point.interpolated(sums.rays, weightOf) * length, double(view.values[pixel]));
            if (std::isnan(change)) return;
            point.spread(length * change, values);
            point.spread(length, weights);
        });
        // Only the ratio of the two counts: a weight is at most 1.
        double most = *std::max_element(weights.begin(), weights.end());
        if (!(most > 0)) most = 1;
        RayPlane<Word> rays = sums;
        for (std::size_t i = 0; i < rays.rays.size(); ++i)
            rays.rays[i] = {units_.correctionWord(values[i] / most),
                            Arithmetic::word(weights[i] / most, units_.weight)};
        return rays;
    }

    static Word valueOf(const Ray<Word>& ray) { return ray.value; }
    static Word weightOf(const Ray<Word>& ray) { return ray.weight; }

    /// What changes voxels together.
    struct Together {
        bool several;  ///< fronts
        bool last;     ///< the last of them
    };

    void backproject(const PerspectiveFront& front, RayPlane<Word> corrections, double relaxation,
                     const Together& fronts) {
        const Journey journey{front, memoryBox_, RayOrder::converging, 1, fronts.last};
        passRegions(bound(backprojecting), journey, std::move(corrections),
                    [&](const RegionPass<Weight>& pass, const RayPlane<Word>& entering) {
                        ExchangeSetup<Word> setup = exchangeSetup(Pass::backproject, relaxation);
                        setup.several = fronts.several || pass.grouped;
                        setup.settle = fronts.last && pass.lastOfRegion;
                        if (setup.several) bytesPerModule = bytesOfModule(2);
                        return run({pass.traversal, pass.slices}, setup, entering, nullptr);
                    });
    }

    RegionBound<Arithmetic> bound(Counters& counters) const { return {arithmetic_, setup_.pipelines, counters}; }

    void noteLargest(const RayPlane<Word>& sums) {
        for (const Ray<Word>& sum : sums.rays) {
            largestSums.value = std::max(largestSums.value, std::abs(double(sum.value) * units_.value));
            largestSums.weight = std::max(largestSums.weight, double(sum.weight) * units_.weight);
        }
    }

    /// (p - A x) / A 1 of a ray of these sums of words; NaN if it does not count.
    double correctionOf(double value, double weight, double measured) {
        const double length = weight * units_.weight, difference = measured - value * units_.value;
        if (!(length > leastLength()) || std::isnan(measured)) return std::nan("");
        if (measured >= setup_.saturation && difference <= 0) return std::nan("");
        squares_ += difference * difference;
        ++used_;
        largestCorrection = std::max(largestCorrection, std::abs(difference / length));
        return difference / length;
    }

    /// RMS of the update's differences.
    double finishedUpdate() {
        for (const Voxel<Word>& voxel : memory_.all())
            largestValue = std::max(largestValue, std::abs(double(voxel.scalar) * units_.value));
        const double rms = used_ > 0 ? std::sqrt(squares_ / double(used_)) : std::nan("");
        squares_ = 0;
        used_ = 0;
        return rms;
    }

    RayPlane<Word> run(const Front& front, Pass pass, double relaxation, const RayPlane<Word>& entering, Trace* trace) {
        return run({front.traversal, front.slices}, exchangeSetup(pass, relaxation), entering, trace);
    }

    ExchangeSetup<Word> exchangeSetup(Pass pass, double relaxation) const {
        ExchangeSetup<Word> setup;
        setup.pass = pass;
        if constexpr (Arithmetic::kExact) {
            setup.relaxation = Word(relaxation);
            setup.bounds = {Word(setup_.lower), Word(setup_.upper)};
        } else {
            setup.relaxation = units_.relaxationWord(relaxation);
            const double most = setup_.largestValue;
            setup.bounds = {Arithmetic::word(std::max(setup_.lower, -most), units_.value),
                            Arithmetic::word(std::min(setup_.upper, most), units_.value)};
        }
        return setup;
    }

    struct Path {
        const Traversal& traversal;
        const std::vector<SliceSetup<Weight>>& slices;
    };

    RayPlane<Word> run(const Path& path, const ExchangeSetup<Word>& setup, const RayPlane<Word>& entering,
                       Trace* trace) {
        PassOptions options;
        options.overlap = setup_.overlap;
        options.trace = trace;
        PassResult<Word> result =
            runPass(arithmetic_, memory_, {path.traversal, path.slices, setup, entering}, setup_.pipelines, options);
        (setup.pass == Pass::project ? projecting : backprojecting) += result.counters;
        const std::size_t bits = setup_.format ? std::size_t(setup_.format->sum) : 8 * sizeof(Word);
        bufferBytes = std::max(bufferBytes, ((result.rayWords + result.bufferWords) * bits + 7) / 8);
        return std::move(result.leaving);
    }

    /// Calls `visit(u, v, ray, pixel)` for all rays of the lattice.
    template <class Visit>
    void forEachRay(const Front& front, const RayPlane<Word>& rays, const Visit& visit) const {
        const LatticeShift shiftU = latticeShift(front.traversal, 0, 0), shiftV = latticeShift(front.traversal, 1, 0);
        for (int v = rays.lowV; v < rays.lowV + rays.height; ++v)
            for (int u = rays.lowU; u < rays.lowU + rays.width; ++u)
                visit(u, v, rays.at(u, v),
                      front.plane.pixelOf(front.traversal, u + shiftU.shift + shiftU.fraction,
                                          v + shiftV.shift + shiftV.fraction, 0));
    }

    /// @param sums words of a voxel in which corrections are added up
    std::size_t bytesOfModule(std::size_t sums) const {
        const NumberFormat format = setup_.format.value_or(NumberFormat{});
        const std::size_t bits =
            setup_.format ? std::size_t(format.scalar) + sums * std::size_t(format.sum) : (1 + sums) * 8 * sizeof(Word);
        return (memory_.voxelsPerModule() * bits + 7) / 8;
    }

    double leastLength() const { return kLeastLength * std::cbrt(box_.voxelVolume()); }
    double clamped(double value) const { return std::clamp(value, setup_.lower, setup_.upper); }

    DenseBox box_;
    Vec3 origin_;
    ReconstructionSetup setup_;
    Arithmetic arithmetic_;
    double squares_ = 0;    ///< of the differences of an update,
    std::size_t used_ = 0;  ///< and their number
    ReconstructionUnits<Arithmetic> units_;
    MemoryBox memoryBox_;
    VoxelMemory<Word> memory_;
};

template <class Arithmetic>
std::unique_ptr<Reconstruction::Machine> loaded(std::unique_ptr<MachineOf<Arithmetic>> machine,
                                                const DenseField& initial, const DenseField& support) {
    machine->load(initial, support);
    return machine;
}

}  // namespace

void ReconstructionSetup::validate() const {
    requireField(pipelines >= 1, "pipelines", pipelines, "at least 1");
    sampling.validate();
    requireField(lower <= upper, "lower", lower, "at most `upper`");
    requireField(largestValue > 0, "largestValue", largestValue, "positive");
    requireField(largestCorrection > 0, "largestCorrection", largestCorrection, "positive");
    if (format) format->validate();
}

Reconstruction::Reconstruction(const DenseBox& box, const Vec3& origin, const ReconstructionSetup& setup,
                               const DenseField& initial, const DenseField& support) {
    setup.validate();
    if (setup.format)
        machine_ = loaded(std::make_unique<MachineOf<FixedPoint>>(box, origin, setup, FixedPoint(*setup.format)),
                          initial, support);
    else
        machine_ = loaded(std::make_unique<MachineOf<FloatArithmetic>>(box, origin, setup, FloatArithmetic()), initial,
                          support);
}
Reconstruction::~Reconstruction() = default;
Reconstruction::Reconstruction(Reconstruction&&) noexcept = default;

double Reconstruction::update(const MeasuredView& view, double relaxation, Trace* trace) {
    return machine_->update(view, relaxation, trace);
}
std::vector<float> Reconstruction::project(const MeasuredView& view) {
    return machine_->project(view);
}
double Reconstruction::update(const MeasuredCone& view, double relaxation, Trace* trace) {
    return machine_->update(view, relaxation, trace);
}
std::vector<float> Reconstruction::project(const MeasuredCone& view) {
    return machine_->project(view);
}
DenseField Reconstruction::volume() const {
    return machine_->volume();
}
double Reconstruction::largestValue() const {
    return machine_->largestValue;
}
double Reconstruction::largestCorrection() const {
    return machine_->largestCorrection;
}
Ray<double> Reconstruction::largestSums() const {
    return machine_->largestSums;
}
const Counters& Reconstruction::projectCounters() const {
    return machine_->projecting;
}
const Counters& Reconstruction::backprojectCounters() const {
    return machine_->backprojecting;
}
std::size_t Reconstruction::bytesPerModule() const {
    return machine_->bytesPerModule;
}
std::size_t Reconstruction::bufferBytes() const {
    return machine_->bufferBytes;
}

}  // namespace raysweep::cube4
