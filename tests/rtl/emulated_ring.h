/// The emulator's stages that hardware/rtl/reverse_lane.sv stands for, of all pipelines.
#pragma once

#include "cube4/delay_line.h"
#include "cube4/exchange.h"
#include "cube4/offer_across.h"
#include "cube4/offer_along.h"
#include "cube4/ray_along.h"
#include "cube4/ray_update.h"

#include <algorithm>

#include "rtl/traced_arithmetic.h"

namespace raysweep::test {

using Word = TracedArithmetic::Word;
using RtlBeam = cube4::Beam<TracedArithmetic::Weight>;

constexpr int kRoundings = 12;  ///< that a pipeline makes in a cycle, in the order of reverse_lane.sv's random words

class EmulatedRing {
  public:
    EmulatedRing(const TracedArithmetic& arithmetic, const cube4::Traversal& traversal, int pipelines, int parts,
                 const cube4::ExchangeSetup<Word>& setup)
        : exchange({pipelines, parts, traversal.reach > 0, 2, 2}, setup),
          rayUpdate(pipelines, setup.pass),
          arithmetic_(arithmetic),
          traversal_(traversal),
          shape_{pipelines, parts, traversal.reach > 0, 2, 2},
          buffer_(traversal, pipelines),
          voxelsWait_(pipelines, 2),
          endingWait_(pipelines, 2),
          rayAcross_(shape_),
          rayAlong_(shape_),
          offerAcross_(shape_),
          offerAlong_(shape_) {}

    /// One cycle. @param random where roundings' words go, kRoundings for each pipeline
    void tick(const RtlBeam& beam, cube4::Lanes<cube4::Voxel<Word>> voxels, const cube4::Lanes<cube4::Ray<Word>>& rays,
              std::uint32_t* random) {
        const std::size_t lanes = rays.size();
        // As Machine::tick (backprojector.cpp): from the last stage to the first.
        const auto& ending = endingWait_.pass(exchange.rays);
        rayUpdate.tick(arithmetic_, offerAlong_.out, ending, offerAlong_.offers, traversal_, buffer_, leaving_);
        std::vector<std::uint32_t> words = arithmetic_.taken();
        std::size_t next = 0;
        if (!words.empty())
            cube4::forEachLane(rayUpdate.out, int(lanes), traversal_.size.x, [&](std::size_t lane, int u) {
                if (u >= traversal_.reach) random[lane * kRoundings + 11] = words.at(next++);
            });
        offerAlong_.tick(arithmetic_, offerAcross_.out, offerAcross_.offers, counters_);
        spread(lanes, random + 9, 2);
        offerAcross_.tick(arithmetic_, exchange.out, exchange.offers, counters_);
        spread(lanes, random + 7, 2);
        exchange.tick(arithmetic_, rayAlong_.out, voxelsWait_.pass(voxels), rayAlong_.rays);
        spreadExchange(lanes, random + 4);
        rayAlong_.tick(arithmetic_, rayAcross_.out, rayAcross_.rays, counters_);
        spread(lanes, random + 2, 2);
        rayAcross_.tick(arithmetic_, beam, rays, counters_);
        spread(lanes, random, 2);
    }

    cube4::Exchange<TracedArithmetic> exchange;
    cube4::RayUpdate<TracedArithmetic> rayUpdate;

  private:
    /// The words of a stage whose pipelines used `each` in turn.
    void spread(std::size_t lanes, std::uint32_t* random, std::size_t each) const {
        const std::vector<std::uint32_t> words = arithmetic_.taken();
        if (words.empty()) return;
        for (std::size_t lane = 0; lane < lanes; ++lane)
            for (std::size_t i = 0; i < each; ++i) random[lane * kRoundings + i] = words.at(lane * each + i);
    }

    /// Backprojecting, only voxels that are changed use one.
    void spreadExchange(std::size_t lanes, std::uint32_t* random) const {
        const std::vector<std::uint32_t> words = arithmetic_.taken();
        const std::size_t used = words.size();
        std::size_t next = 0;
        for (std::size_t lane = 0; lane < lanes && next < used; ++lane)
            if (used == 3 * lanes)
                for (std::size_t i = 0; i < 3; ++i) random[lane * kRoundings + i] = words[next++];
            else if (exchange.voxels[lane].gain != 0 && exchange.rays[lane].across.weight != 0)
                random[lane * kRoundings] = words[next++];
    }

    const TracedArithmetic& arithmetic_;
    const cube4::Traversal& traversal_;
    cube4::StageShape shape_;
    cube4::RayBuffer<Word> buffer_;
    cube4::RayPlane<Word> leaving_;
    cube4::Counters counters_;
    cube4::DelayLine<cube4::Voxel<Word>> voxelsWait_;
    cube4::DelayLine<cube4::RayAcross<TracedArithmetic>::Rays> endingWait_;
    cube4::RayAcross<TracedArithmetic> rayAcross_;
    cube4::RayAlong<TracedArithmetic> rayAlong_;
    cube4::OfferAcross<TracedArithmetic> offerAcross_;
    cube4::OfferAlong<TracedArithmetic> offerAlong_;
};

}  // namespace raysweep::test
