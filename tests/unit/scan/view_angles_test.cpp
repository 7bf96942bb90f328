// Angles in files: which unit they are in, and text files of them.
#include "raysweep/scan/view_angles.h"

#include "support/temporary_folder.h"
#include "support/volume_files.h"
#include "unit/scan/ct_fixture.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

std::vector<double> inRadians(std::vector<double> degrees) {
    for (double& angle : degrees) angle *= kPi / 180;
    return degrees;
}

void expectNear(const std::vector<double>& is, const std::vector<double>& shouldBe) {
    ASSERT_EQ(is.size(), shouldBe.size());
    for (std::size_t n = 0; n < is.size(); ++n) EXPECT_NEAR(is[n], shouldBe[n], 1e-12 * 360) << n;  // doubles
}

}  // namespace

TEST(ViewAngles, TheUnitIsThatOfTheFile) {
    const std::vector<double> degrees = anglesFrom(0, 2, 90);
    for (const char* units : {"rad", "radians", "Radian"}) {
        const ViewAngles angles = viewAngles(inRadians(degrees), units, {});
        expectNear(angles.degrees, degrees);
        EXPECT_NE(angles.said, "") << units;
    }
    for (const char* units : {"deg", "degrees", "\xc2\xb0"}) {
        const ViewAngles angles = viewAngles(degrees, units, {});
        expectNear(angles.degrees, degrees);
        EXPECT_EQ(angles.said, "") << units;
    }
    EXPECT_NE(viewAngles(degrees, "gon", {}).said.find("'gon', is not known"), std::string::npos);
}

TEST(ViewAngles, WithoutAUnitRadiansAreKnownByWhatTheyCover) {
    struct Turn {
        double first, arc;
        int views;
    };
    for (const Turn& turn : {Turn{0, 180, 90}, {-90, 180, 181}, {0, 360, 720}, {30, -360, 45}, {0, 200, 100}}) {
        const std::vector<double> degrees = anglesFrom(turn.first, turn.arc / turn.views, turn.views);
        const ViewAngles taken = viewAngles(inRadians(degrees), "", {});
        expectNear(taken.degrees, degrees);
        EXPECT_NE(taken.said.find("taken for radians"), std::string::npos) << turn.arc;
        const ViewAngles plain = viewAngles(degrees, "", {});
        expectNear(plain.degrees, degrees);
        EXPECT_EQ(plain.said, "") << turn.arc;
    }
    expectNear(viewAngles({0, 1, 2, 3}, "", {}).degrees, {0, 1, 2, 3});  // whole numbers are degrees
    expectNear(viewAngles(anglesFrom(0, 0.5, 60), "", {}).degrees, anglesFrom(0, 0.5, 60));  // 30 degrees
}

TEST(ViewAngles, WhatIsAskedForIsDoneAndWhatLooksAmissIsSaid) {
    const std::vector<double> degrees = anglesFrom(0, 2, 90);
    expectNear(viewAngles(inRadians(degrees), "deg", AngleUnit::radians).degrees, degrees);
    const ViewAngles few = viewAngles(inRadians(degrees), "deg", {});
    expectNear(few.degrees, inRadians(degrees));
    EXPECT_NE(few.said.find("3.142 degrees only"), std::string::npos) << few.said;
    const ViewAngles many = viewAngles(degrees, "rad", {});
    EXPECT_NE(many.said.find("28.6 turns"), std::string::npos) << many.said;
    EXPECT_EQ(viewAngles(degrees, "rad", AngleUnit::degrees).said, "");
}

TEST(AngleFile, NumbersMayBeSeparatedAsTheyLike) {
    TemporaryFolder folder;
    const std::string path = folder / "angles.txt";
    for (const char* text :
         {"0\n1.5\n-3e1\n", "0, 1.5 -30", "\xef\xbb\xbf# degrees\r\n0;1.5\r\n-30 # last\r\n", "+0\t1.5,\n\n-30"}) {
        writeFile(path, text);
        EXPECT_EQ(readAngleFile(path), (std::vector<double>{0, 1.5, -30})) << text;
    }
}

TEST(AngleFile, WhatIsNoAngleIsRefusedByItsLine) {
    TemporaryFolder folder;
    const std::string path = folder / "angles.txt";
    const auto expectRefused = [&](const std::string& text, const std::string& message) {
        writeFile(path, text);
        expectError<IoError>([&] { readAngleFile(path); }, message);
    };
    expectRefused("0\n1\ntwo\n", "line 3: 'two' is no angle");
    expectRefused("0\n1 nan", "line 2: 'nan' is no angle");
    expectRefused("0 1e999", "line 1: '1e999' is no angle");
    expectRefused("0 1.5.2", "line 1: '1.5.2' is no angle");
    expectRefused(std::string("0 1\0 2", 6), "is no angle");
    expectRefused("# nothing\n", "it has no angles");
    expectError<IoError>([&] { readAngleFile(folder / "missing.txt"); }, "there is no such file");
    expectError<IoError>([&] { readAngleFile(folder / ""); }, "it is a folder");
}
