/// The page that writeSectionPage writes: what stands before the volume's data, and after. For this module's own
/// sources.
#pragma once

namespace raysweep {

extern const char* const kPageBeforeData;
extern const char* const kPageAfterData;

}  // namespace raysweep
