#include "raysweep/formats/itk_silence.h"

#include <gdcmTrace.h>
#include <itkObject.h>

namespace raysweep {

Silence::Silence() : cerr_(std::cerr.rdbuf(kept_.rdbuf())), cout_(std::cout.rdbuf(kept_.rdbuf())) {
    itk::Object::SetGlobalWarningDisplay(false);
    gdcm::Trace::WarningOff();
    gdcm::Trace::ErrorOff();
    gdcm::Trace::DebugOff();
}

Silence::~Silence() {
    std::cerr.rdbuf(cerr_);
    std::cout.rdbuf(cout_);
}

}  // namespace raysweep
