#include "cube4/reconstruction.h"

#include "cube4/arithmetic.h"

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
          memory_(box.size() + Index3(2 * kPad), setup.pipelines) {
        if constexpr (!Arithmetic::kExact) {
            const NumberFormat& format = arithmetic_.format();
            const int sign = setup.lower < 0 ? 1 : 0;
            valueUnit_ = setup.largestValue / (std::ldexp(1.0, format.scalar - sign) - 1);
            correctionUnit_ = setup.largestCorrection / (std::ldexp(1.0, format.energy - 1) - 1);
            weightUnit_ = std::ldexp(1.0, -format.weight);
            format.requireSumsHold(setup.largestSums.value / valueUnit_, "sums of voxels along a ray");
            format.requireSumsHold(setup.largestSums.weight / weightUnit_, "sums of weights along a ray");
        }
        const std::size_t bits = setup.format ? std::size_t(setup.format->scalar) : 8 * sizeof(Word);
        bytesPerModule = (memory_.voxelsPerModule() * bits + 7) / 8;
    }

    void load(const DenseField& initial, const DenseField& support) {
        forEachVoxel([&](std::size_t i, Voxel<Word>& voxel) {
            voxel.scalar = initial.empty() ? Word{} : toWord(clamped(double(initial[i])), valueUnit_);
            voxel.gain = support.empty() || support[i] > 0 ? toWord(1, weightUnit_) : Word{};
        });
    }

    double update(const MeasuredView& view, double relaxation, Trace* trace) override {
        const Front front = frontOf(view);
        const RayPlane<Word> sums = run(front, Pass::project, 0, RayPlane<Word>(front.traversal, front.slices), trace);
        RayPlane<Word> corrections = sums;
        double squares = 0;
        std::size_t used = 0;
        forEachRay(front, sums, [&](int u, int v, const Ray<Word>& sum, const Imath::V2d& pixel) {
            Ray<Word>& ray = corrections.at(u, v);
            ray = {};
            largestSums.value = std::max(largestSums.value, std::abs(double(sum.value) * valueUnit_));
            largestSums.weight = std::max(largestSums.weight, double(sum.weight) * weightUnit_);
            const double length = double(sum.weight) * weightUnit_ * front.traversal.stepLength;
            const double measured = double(sampleOf(view.values, view.width, view.height, pixel));
            if (!(length > leastLength()) || std::isnan(measured)) return;
            const double difference = measured - double(sum.value) * valueUnit_ * front.traversal.stepLength;
            if (measured >= setup_.saturation && difference <= 0) return;
            squares += difference * difference;
            ++used;
            const double correction = difference / length;
            largestCorrection = std::max(largestCorrection, std::abs(correction));
            ray = {toCorrection(correction), toWord(1, weightUnit_)};
        });
        run(front, Pass::backproject, relaxation, corrections, trace);
        for (const Voxel<Word>& voxel : memory_.all())
            largestValue = std::max(largestValue, std::abs(double(voxel.scalar) * valueUnit_));
        return used > 0 ? std::sqrt(squares / double(used)) : std::nan("");
    }

    std::vector<float> project(const MeasuredView& view) override {
        const Front front = frontOf(view);
        const RayPlane<Word> sums =
            run(front, Pass::project, 0, RayPlane<Word>(front.traversal, front.slices), nullptr);
        std::vector<float> lattice;
        for (const Ray<Word>& sum : sums.rays)
            lattice.push_back(float(double(sum.value) * valueUnit_ * front.traversal.stepLength));
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
        const_cast<MachineOf*>(this)->forEachVoxel(
            [&](std::size_t i, const Voxel<Word>& voxel) { field[i] = float(double(voxel.scalar) * valueUnit_); });
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

    RayPlane<Word> run(const Front& front, Pass pass, double relaxation, const RayPlane<Word>& entering, Trace* trace) {
        ExchangeSetup<Word> setup;
        setup.pass = pass;
        if constexpr (Arithmetic::kExact) {
            setup.relaxation = Word(relaxation);
            setup.bounds = {Word(setup_.lower), Word(setup_.upper)};
        } else {
            setup.relaxation =
                toWord(relaxation * correctionUnit_ / valueUnit_, std::ldexp(1.0, -arithmetic_.relaxationBits()));
            const double most = setup_.largestValue;
            setup.bounds = {toWord(std::max(setup_.lower, -most), valueUnit_),
                            toWord(std::min(setup_.upper, most), valueUnit_)};
        }
        PassOptions options;
        options.overlap = setup_.overlap;
        options.trace = trace;
        PassResult<Word> result =
            runPass(arithmetic_, memory_, {front.traversal, front.slices, setup, entering}, setup_.pipelines, options);
        (pass == Pass::project ? projecting : backprojecting) += result.counters;
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

    template <class Visit>
    void forEachVoxel(const Visit& visit) {
        const Index3 size = box_.size();
        std::size_t i = 0;
        for (int z = 0; z < size.z; ++z)
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x) visit(i++, memory_.at(Index3(x, y, z) + Index3(kPad)));
    }

    double leastLength() const { return kLeastLength * std::cbrt(box_.voxelVolume()); }
    double clamped(double value) const { return std::clamp(value, setup_.lower, setup_.upper); }

    static Word toWord(double value, double unit) {
        if constexpr (Arithmetic::kExact) return Word(value);
        return Word(std::llround(value / unit));
    }

    /// Saturates: a correction that is too large is made in several passes.
    Word toCorrection(double value) const {
        if constexpr (Arithmetic::kExact) return Word(value);
        return toWord(std::clamp(value, -setup_.largestCorrection, setup_.largestCorrection), correctionUnit_);
    }

    DenseBox box_;
    Vec3 origin_;
    ReconstructionSetup setup_;
    Arithmetic arithmetic_;
    double valueUnit_ = 1, correctionUnit_ = 1, weightUnit_ = 1;
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
