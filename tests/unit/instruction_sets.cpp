#include "unit/instruction_sets.h"

#include "raysweep/core/simd_targets.h"  // before Highway

#include <gtest/gtest.h>
#include <hwy/highway.h>

namespace raysweep::test {
namespace {

/// @param targets 0: the best again
void allow(std::int64_t targets) {
    hwy::SetSupportedTargetsForTest(targets);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace

void forEachInstructionSet(const std::function<void()>& use) {
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
        allow(target);
        SCOPED_TRACE(hwy::TargetName(target));
        use();
    }
    allow(0);
}

}  // namespace raysweep::test
