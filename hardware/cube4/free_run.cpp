#include "cube4/free_run.h"

#include "raysweep/core/require.h"
#include "raysweep/core/shuffle.h"

#include <ImathQuat.h>

#include <cmath>
#include <numeric>
#include <random>

namespace raysweep::cube4 {
namespace {

constexpr int kLook = 8;  ///< finishing sweeps between looks at what is left
constexpr int kMostFinishing = 2000;

/// Directions that are spread evenly over the sphere, in random order; batches turned at random about a random axis.
class Directions {
  public:
    Directions(int batch, std::uint64_t seed) : batch_(batch), random_(seed), order_(std::uint32_t(seed)) {}

    Vec3 next() {
        if (left_.empty()) refill();
        const Vec3 direction = left_.back();
        left_.pop_back();
        return direction;
    }
    double uniform() { return double(random_() >> 11) * 0x1.0p-53; }

  private:
    void refill() {
        // A random rotation as a unit quaternion (Shoemake 1992).
        const double u = uniform(), a = 2 * kPi * uniform(), b = 2 * kPi * uniform();
        const Imath::Quatd turn(std::sqrt(1 - u) * std::sin(a), std::sqrt(1 - u) * std::cos(a),
                                std::sqrt(u) * std::sin(b), std::sqrt(u) * std::cos(b));
        const double golden = kPi * (3 - std::sqrt(5.0));
        for (int i = 0; i < batch_; ++i) {
            const double z = (2 * i + 1.0) / batch_ - 1, r = std::sqrt(1 - z * z);
            left_.push_back(turn.rotateVector(Vec3(r * std::cos(golden * i), r * std::sin(golden * i), z)));
        }
        shuffle(left_, order_);
    }

    int batch_;
    std::mt19937_64 random_;
    std::mt19937 order_;
    std::vector<Vec3> left_;
};

}  // namespace

void SceneLight::validate() const {
    requireField(sweeps >= 1, "sweeps", sweeps, "at least 1");
    requireField(sky >= 0 && std::isfinite(sky), "sky", sky, "0 or more, and finite");
    requireField(unshotShare > 0 && unshotShare <= 1, "unshotShare", unshotShare, "in (0,1]");
    for (const DenseSun& sun : suns) {
        requireField(sun.irradiance >= 0 && std::isfinite(sun.irradiance), "irradiance of a sun", sun.irradiance,
                     "0 or more, and finite");
        requireField(sun.direction.length() > 0, "length of a sun's direction", sun.direction.length(), "above 0");
    }
}

void addDirectLight(DenseMedium& medium, const IlluminationSetup& setup, const std::vector<DenseSun>& suns) {
    if (suns.empty()) return;
    if (medium.source.empty()) medium.source.assign(medium.extinction.size(), 0.0f);
    const DenseField gain = effectiveAlbedo(medium, setup.rule);
    for (const DenseSun& sun : suns) {
        FrontPower power;
        const DenseField deposit = directDeposit(medium, setup, sun.direction, power);
        const double scale = sun.irradiance * crossSection(medium.box, sun.direction);
        for (std::size_t i = 0; i < deposit.size(); ++i)
            medium.source[i] += gain[i] * float(double(deposit[i]) * scale);
    }
}

FreeRun runFreely(Illumination& machine, const DenseBox& box, double sourcePower, const SceneLight& light,
                  const ProgressCallback& progress, Trace* trace) {
    light.validate();
    FreeRun run;
    Directions directions(light.sweeps, light.seed);
    const auto sweep = [&](bool inject) {
        SweepFront front{directions.next(), 0, 0, 0};
        front.offsetU = directions.uniform();
        front.offsetV = directions.uniform();
        // One direction stands for the whole sphere.
        if (inject) front.entering = light.sky * 4 * kPi * crossSection(box, front.direction);
        const FrontPower power = machine.sweep({front}, inject, trace).front();
        run.power.entered += power.entered;
        run.power.escaped += power.escaped;
        run.sweeps.push_back({front, inject});
    };
    for (int n = 0; n < light.sweeps; ++n) {
        if (!report(progress, "sweeping", double(n) / light.sweeps)) {
            run.complete = false;
            return run;
        }
        sweep(true);
        ++run.injections;
    }
    const double enough = light.unshotShare * (run.power.entered + sourcePower * run.injections);
    for (int n = 0; n < kMostFinishing && sumOf(machine.unshot()) > enough; n += kLook) {
        if (!report(progress, "finishing", 0)) {
            run.complete = false;
            return run;
        }
        for (int i = 0; i < kLook; ++i) sweep(false);
    }
    const double all = run.power.entered + sourcePower * run.injections;
    if (all > 0) run.unshotShare = sumOf(machine.unshot()) / all;
    return run;
}

bool repeat(const FreeRun& run, Illumination& machine, const ProgressCallback& progress) {
    for (std::size_t n = 0; n < run.sweeps.size(); ++n) {
        if (!report(progress, "the same in the format", double(n) / double(run.sweeps.size()))) return false;
        machine.sweep({run.sweeps[n].front}, run.sweeps[n].inject);
    }
    return true;
}

}  // namespace raysweep::cube4
