/// Fills an IlluminationRecord while a scene is solved.
#pragma once

#include "raysweep/illuminate/illumination_record.h"
#include "raysweep/illuminate/state.h"

#include <vector>

namespace raysweep {

/// Begins the record with what is known before the first sweep. @param state with direct light
void recordScene(IlluminationRecord& record, const SolverState& state, const Scene& scene,
                 const IlluminateOptions& options);

class SweepRecorder {
  public:
    /// All three must outlive it; `state` is looked at in each call.
    SweepRecorder(IlluminationRecord& record, const SolverState& state, const Scene& scene)
        : record_(record), state_(state), transform_(scene.medium.density->transform()) {}

    /// Before the first group. @param fromCoarse with unshot power
    void begin(const ExchangeConstants& constants, bool fromCoarse);
    /// After the last one.
    void end();
    /// After whatever then became of unshot power. @param onCoarse a coarse level settled it
    void settle(bool onCoarse);

  private:
    openvdb::GridBase::Ptr gridOf(const BrickField* fields) const;
    BrickField depositOf(int channel) const;

    IlluminationRecord& record_;
    const SolverState& state_;
    const openvdb::math::Transform& transform_;
    std::vector<BrickField> deposit_;  ///< at the end of the last group
};

}  // namespace raysweep
