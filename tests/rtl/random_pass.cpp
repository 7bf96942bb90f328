#include "rtl/random_pass.h"

#include <algorithm>

namespace raysweep::test {
namespace {

constexpr int kTableBits = 8;  ///< of a scalar that address the tables of opacity and of what is shot
constexpr int kMostRows = 6, kMostSlices = 4, kDrain = 8;

}  // namespace

RandomPass::RandomPass(const RingFormat& format, cube4::Pass pass, Word relaxation, std::mt19937_64& random)
    : format_(format), random_(random) {
    const cube4::NumberFormat& number = format.number;
    traversal.reach = chance(0.8) ? 1 : 0;
    traversal.size =
        Index3(1 + int(below(format.parts * format.pipelines)), 1 + int(below(kMostRows)), 1 + int(below(kMostSlices)));
    parts = (traversal.size.x + format.pipelines - 1) / format.pipelines;

    setup.pass = pass;
    setup.inject = chance(0.5);
    setup.group = chance(0.5);
    setup.settle = chance(0.5);
    setup.tableShift = std::max(0, number.scalar - kTableBits);
    for (int i = 0; i < 1 << (number.scalar - setup.tableShift); ++i) {
        setup.opacity.push_back(part(number.part));
        setup.shot.push_back(part(number.part));
    }
    signedValue = pass == cube4::Pass::backproject && chance(0.5);
    setup.relaxation = relaxation;
    const Word least = signedValue ? -(Word(1) << (number.scalar - 1)) : 0;
    setup.bounds = {least + word(number.scalar), least + word(number.scalar)};
    if (chance(0.5)) setup.bounds = {least, least + (Word(1) << number.scalar) - 1};
    if (setup.bounds.value > setup.bounds.weight) std::swap(setup.bounds.value, setup.bounds.weight);

    makeSlices(traversal.size.z);
    makeBeams();
}

/// Any word, with the largest, the smallest and small ones more often than by chance.
Word RandomPass::word(int bits) {
    const Word end = Word(1) << bits;
    if (chance(0.7)) return below(end);
    return chance(0.5) ? end - 1 - below(2) : below(3);
}

/// Part of 1, which has a code of its own.
Word RandomPass::part(int bits) {
    const Word one = Word(1) << bits;
    if (chance(0.7)) return below(one + 1);
    return chance(0.5) ? one - below(2) : below(2);
}

void RandomPass::makeSlices(int slices) {
    const Word one = Word(1) << format_.number.weight;
    for (int k = 0; k < slices; ++k) {
        cube4::SliceSetup<Word> slice;
        slice.number = k;
        slice.u.high = part(format_.number.weight);
        slice.v.high = part(format_.number.weight);
        slice.u.low = one - slice.u.high;
        slice.v.low = one - slice.v.high;
        slices_.push_back(slice);
    }
}

void RandomPass::makeBeams() {
    const double bubbles = chance(0.3) ? 0 : 0.5;
    for (const cube4::SliceSetup<Word>& slice : slices_)
        for (int row = 0; row < traversal.size.y; ++row)
            for (int part = 0; part < parts; ++part) {
                while (chance(bubbles)) beams_.emplace_back();
                const int first = (part * format_.pipelines + row + slice.number) % format_.pipelines;
                beams_.push_back({&slice, row, part, first});
            }
    beams_.resize(beams_.size() + kDrain);
}

cube4::Voxel<Word> RandomPass::voxel() {
    const cube4::NumberFormat& number = format_.number;
    cube4::Voxel<Word> voxel;
    voxel.scalar = word(number.scalar);
    if (signedValue) voxel.scalar -= Word(1) << (number.scalar - 1);
    voxel.gain = part(number.part);
    voxel.source = word(number.energy);
    voxel.unshot = word(number.energy);
    voxel.deposit = word(number.sum);
    // What is left of U is not below 0.
    voxel.fresh = chance(0.2) ? 0 : chance(0.5) ? word(number.energy) : -below(voxel.unshot + 1);
    return voxel;
}

cube4::Ray<Word> RandomPass::ray() {
    const cube4::NumberFormat& number = format_.number;
    if (setup.pass != cube4::Pass::backproject) return {word(number.energy), 0};
    // A correction, and 1 if the ray counts; parts of 1 never come, but are no different.
    cube4::Ray<Word> ray;
    ray.value = word(number.energy) - (Word(1) << (number.energy - 1));
    ray.weight = chance(0.7) ? Word(1) << number.weight : chance(0.7) ? 0 : part(number.weight);
    return ray;
}

}  // namespace raysweep::test
