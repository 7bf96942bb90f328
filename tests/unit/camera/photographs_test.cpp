// Photographs made smaller.
#include "raysweep/camera/photographs.h"

#include "raysweep/core/error.h"

#include <gtest/gtest.h>

#include "support/expect_error.h"

namespace raysweep {

// Columns and rows that fill no square are left out of the picture, and so of what the camera sees.
TEST(Photographs, RaysOfReducedPixelsGoThroughTheMiddlesOfTheirSquares) {
    constexpr int kFactor = 4;
    Camera camera;
    camera.width = 103;
    camera.height = 66;
    const Photograph whole{"view", photoCamera(camera), Image(camera.width, camera.height, 4)};
    const Photograph small = reduced(whole, kFactor);
    EXPECT_EQ(small.matte.width, 25);
    EXPECT_EQ(small.matte.height, 16);
    requireUsable({small});
    for (const int x : {0, 12, 24})
        for (const int y : {0, 7, 15}) {
            const Ray a = pixelRay(small.camera, x + 0.5, y + 0.5);
            const Ray b = pixelRay(whole.camera, kFactor * (x + 0.5), kFactor * (y + 0.5));
            EXPECT_LT((a.direction - b.direction).length(), 1e-14) << x << " " << y;
        }
}

TEST(Photographs, WhatCannotBeUsedIsNamed) {
    test::expectError<InvalidArgument>([] { requireUsable({}); }, "no photographs");
    Camera camera;
    camera.width = camera.height = 8;
    const Photograph opaque{"opaque.png", photoCamera(camera), Image(8, 8, 3)};
    test::expectError<InvalidArgument>([&] { requireUsable({opaque}); }, "opaque.png has no alpha");
    const Photograph cropped{"cropped.png", photoCamera(camera), Image(8, 7, 4)};
    test::expectError<InvalidArgument>([&] { requireUsable({cropped}); }, "cropped.png is not of the size");
}

}  // namespace raysweep
