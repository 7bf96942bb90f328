// reverse_lane.sv against the emulator's stages, in lock step: the same random beams, and all words that leave in a
// cycle compared bit for bit, and whether any do.
#include <cstdio>
#include <utility>

#include "rings.h"  // made by CMakeLists.txt
#include "rtl/random_pass.h"

using namespace raysweep;
using test::Word;

namespace {

constexpr int kBeams = 100000;        ///< of each ring and pass
constexpr int kPassesOfATable = 100;  ///< that have the same λ: loading its table takes 2^weight cycles

template <class Model>
class Comparison {
  public:
    Comparison(const test::RingFormat& format, const char* name)
        : format_(format), name_(name), lanes_(std::size_t(format.pipelines)), arithmetic_(format.number) {
        model_.reset = 1;
        cycle();
        model_.reset = 0;
    }

    void run(cube4::Pass pass) {
        int beams = 0;
        Word relaxation = 0;
        for (int n = 0; beams < kBeams; ++n) {
            if (n % kPassesOfATable == 0 && pass == cube4::Pass::backproject) relaxation = loadFactors();
            test::RandomPass random(format_, pass, relaxation, random_);
            runPass(random);
            for (const test::RtlBeam& beam : random.beams()) beams += bool(beam);
        }
        std::printf("%-34s %-11s %d beams, %llu words compared, %llu differ; a voxel takes %d cycles, a ray %d\n",
                    name_, pass == cube4::Pass::illuminate ? "illuminate" : "backproject", beams,
                    static_cast<unsigned long long>(std::exchange(compared_, 0)),
                    static_cast<unsigned long long>(differ_), voxelLatency_, rayLatency_);
    }

    bool same() const { return differ_ == 0; }

  private:
    void cycle() {
        model_.clk = 0;
        model_.eval();
        model_.clk = 1;
        model_.eval();
    }

    /// @return a new λ, whose table it has loaded
    Word loadFactors() {
        const int weightBits = format_.number.weight;
        const Word relaxation = Word(random_() % (std::uint64_t(1) << (format_.factor - weightBits)));
        model_.valid = 0;
        model_.factorLoads = 1;
        for (Word weight = 1; weight <= Word(1) << weightBits; ++weight) {
            model_.factorAt = std::uint64_t(weight);
            model_.factorEntry = std::uint64_t(((relaxation << weightBits) + weight / 2) / weight);
            cycle();
        }
        model_.factorLoads = 0;
        return relaxation;
    }

    void runPass(test::RandomPass& random) {
        test::EmulatedRing ring(arithmetic_, random.traversal, format_.pipelines, random.parts, random.setup);
        model_.linear = random.traversal.reach > 0;
        model_.backproject = random.setup.pass == cube4::Pass::backproject;
        model_.inject = random.setup.inject;
        model_.group = random.setup.group;
        model_.settle = random.setup.settle;
        model_.signedValue = random.signedValue;
        model_.lowest = std::uint64_t(random.setup.bounds.value);
        model_.highest = std::uint64_t(random.setup.bounds.weight);
        int at = 0, firstIn = -1, firstVoxel = -1, firstRay = -1;
        for (const test::RtlBeam& beam : random.beams()) {
            cube4::Lanes<cube4::Voxel<Word>> voxels(lanes_);
            cube4::Lanes<cube4::Ray<Word>> rays(lanes_);
            for (std::size_t lane = 0; lane < lanes_; ++lane) {
                voxels[lane] = random.voxel();
                rays[lane] = random.ray();
            }
            drive(beam, voxels, rays, random);
            ring.tick(beam, voxels, rays, &model_.random[0]);
            cycle();
            compare(ring);
            ++at;
            if (beam && firstIn < 0) firstIn = at - 1;
            if (model_.voxelValid && firstVoxel < 0) firstVoxel = at;
            if (model_.rayValid && firstRay < 0) firstRay = at;
        }
        voxelLatency_ = firstVoxel - firstIn;
        rayLatency_ = firstRay - firstIn;
    }

    void drive(const test::RtlBeam& beam, const cube4::Lanes<cube4::Voxel<Word>>& voxels,
               const cube4::Lanes<cube4::Ray<Word>>& rays, const test::RandomPass& random) {
        model_.valid = bool(beam);
        // In a bubble whatever is on the wires has to be without effect.
        model_.first = beam ? std::uint32_t(beam.first) : std::uint32_t(random_() % lanes_);
        model_.part = beam ? std::uint32_t(beam.part) : std::uint32_t(random_() % std::uint64_t(format_.parts));
        model_.row = beam ? std::uint32_t(beam.row) : std::uint32_t(random_() % 2);
        model_.uHigh = beam ? std::uint64_t(beam.slice->u.high) : random_();
        model_.vHigh = beam ? std::uint64_t(beam.slice->v.high) : random_();
        for (std::size_t lane = 0; lane < lanes_; ++lane) {
            const cube4::Voxel<Word>& voxel = voxels[lane];
            const Word least = random.signedValue ? Word(1) << (format_.number.scalar - 1) : 0;
            const auto entry = std::size_t((voxel.scalar + least) >> random.setup.tableShift);
            model_.opacity[lane] = std::uint64_t(random.setup.opacity[entry]);
            model_.shot[lane] = std::uint64_t(random.setup.shot[entry]);
            model_.gain[lane] = std::uint64_t(voxel.gain);
            model_.source[lane] = std::uint64_t(voxel.source);
            model_.unshot[lane] = std::uint64_t(voxel.unshot);
            model_.fresh[lane] = std::uint64_t(voxel.fresh);
            model_.deposit[lane] = std::uint64_t(voxel.deposit);
            model_.scalar[lane] = std::uint64_t(voxel.scalar);
            model_.value[lane] = std::uint64_t(rays[lane].value);
            model_.weight[lane] = std::uint64_t(rays[lane].weight);
        }
    }

    void compare(const test::EmulatedRing& ring) {
        const std::uint64_t all = (std::uint64_t(1) << lanes_) - 1;
        const bool voxels = bool(ring.exchange.out), rays = bool(ring.rayUpdate.out);
        expect("voxels are valid", model_.voxelValid, voxels ? all : 0);
        expect("rays are valid", model_.rayValid, rays ? all : 0);
        for (std::size_t lane = 0; lane < lanes_; ++lane) {
            if (voxels) {
                const cube4::Voxel<Word>& voxel = ring.exchange.voxels[lane];
                expect("unshot power", model_.unshotOut[lane], std::uint64_t(voxel.unshot));
                expect("fresh power", model_.freshOut[lane], std::uint64_t(voxel.fresh));
                expect("deposit", model_.depositOut[lane], std::uint64_t(voxel.deposit));
                expect("scalar", model_.scalarOut[lane], std::uint64_t(voxel.scalar));
            }
            if (rays && ring.rayUpdate.rays[lane].slot >= 0) {
                const cube4::Ray<Word>& ray = ring.rayUpdate.rays[lane].ray;
                expect("value of a ray", model_.valueOut[lane], std::uint64_t(ray.value));
                expect("weight of a ray", model_.weightOut[lane], std::uint64_t(ray.weight));
            }
        }
    }

    void expect(const char* what, std::uint64_t found, std::uint64_t expected) {
        ++compared_;
        if (found == expected) return;
        if (++differ_ <= 5)
            std::printf("%s: %s is %lld, the emulator's %lld\n", name_, what, static_cast<long long>(found),
                        static_cast<long long>(expected));
    }

    test::RingFormat format_;
    const char* name_;
    std::size_t lanes_;
    test::TracedArithmetic arithmetic_;
    Model model_;
    std::mt19937_64 random_{11};
    std::uint64_t compared_ = 0, differ_ = 0;
    int voxelLatency_ = 0, rayLatency_ = 0;
};

template <class Model>
bool matches(const test::RingFormat& format, const char* name) {
    Comparison<Model> comparison(format, name);
    comparison.run(cube4::Pass::illuminate);
    comparison.run(cube4::Pass::backproject);
    return comparison.same();
}

}  // namespace

int main() {
    bool all = true;
#define COMPARE(Model, format, name) all = matches<Model>(format, name) && all;
    RTL_RINGS(COMPARE)
#undef COMPARE
    return all ? 0 : 1;
}
