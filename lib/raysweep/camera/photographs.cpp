#include "raysweep/camera/photographs.h"

#include "raysweep/core/error.h"
#include "raysweep/image/matte_picture.h"

namespace raysweep {

Photograph reduced(const Photograph& photograph, int factor) {
    Photograph to{photograph.name, photograph.camera, reduced(photograph.matte, factor)};
    to.camera.width = to.matte.width * factor;  // without what fills no square
    to.camera.height = to.matte.height * factor;
    to.camera = resized(to.camera, to.matte.width, to.matte.height);
    return to;
}

void requireUsable(const std::vector<Photograph>& photographs) {
    if (photographs.empty()) throw InvalidArgument("no photographs");
    for (const Photograph& photograph : photographs) {
        photograph.camera.validate();
        if (photograph.matte.channels != 4)
            throw InvalidArgument(photograph.name + " has no alpha; free it of its backdrop first");
        if (photograph.camera.width != photograph.matte.width || photograph.camera.height != photograph.matte.height)
            throw InvalidArgument(photograph.name + " is not of the size that its camera has");
    }
}

}  // namespace raysweep
