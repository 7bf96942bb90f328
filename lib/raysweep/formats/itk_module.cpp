/// The way into the module `raysweep_medical`.
#include "raysweep/formats/itk_formats.h"

extern "C" const raysweep::ItkFormats* raysweepItkFormats() {
    static constexpr raysweep::ItkFormats kFormats{raysweep::kItkFormatsVersion, raysweep::itkSeries,
                                                   raysweep::itkWrite};
    return &kFormats;
}
