/// Random passes: as many beams as a small slice has, with random words of all voxels and rays, and bubbles in between.
#pragma once

#include <random>

#include "rtl/emulated_ring.h"

namespace raysweep::test {

/// What a ring is made for.
struct RingFormat {
    cube4::NumberFormat number;
    int pipelines = 1;
    int factor = 32;  ///< bits of λ / weight
    int parts = 4;    ///< partial beams of a beam, at most
};

class RandomPass {
  public:
    RandomPass(const RingFormat& format, cube4::Pass pass, Word relaxation, std::mt19937_64& random);

    /// All beams in their order, with bubbles (null slices) between some of them, and at the end until all are out.
    const std::vector<RtlBeam>& beams() const { return beams_; }
    cube4::Voxel<Word> voxel();
    cube4::Ray<Word> ray();

    cube4::Traversal traversal;
    int parts = 1;
    cube4::ExchangeSetup<Word> setup;
    bool signedValue = false;

  private:
    Word below(Word end) { return Word(random_() % std::uint64_t(end)); }
    bool chance(double probability) { return double(random_() >> 11) * 0x1p-53 < probability; }
    Word word(int bits);
    Word part(int bits);
    void makeSlices(int slices);
    void makeBeams();

    RingFormat format_;
    std::mt19937_64& random_;
    std::vector<cube4::SliceSetup<Word>> slices_;
    std::vector<RtlBeam> beams_;
};

}  // namespace raysweep::test
