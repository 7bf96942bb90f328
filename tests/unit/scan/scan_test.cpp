// One call reads a scan: line integrals and rays are those that its parts make, what was found or taken for granted is
// said, and what does not go together is refused before anything is read.
#include "raysweep/scan/scan.h"

#include "raysweep/formats/itk_volume.h"
#include "raysweep/scan/geometry_io.h"
#include "raysweep/scan/line_integrals.h"
#include "raysweep/scan/ring_filter.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "support/temporary_folder.h"
#include "unit/scan/ct_fixture.h"
#include "unit/scan/hdf5_file.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

void expectSameValues(const Projections& is, const Projections& shouldBe) {
    ASSERT_EQ(is.values.size(), shouldBe.values.size());
    for (std::size_t p = 0; p < is.values.size(); ++p)
        EXPECT_TRUE(is.values[p] == shouldBe.values[p] || (std::isnan(is.values[p]) && std::isnan(shouldBe.values[p])))
            << p << ": " << is.values[p] << " " << shouldBe.values[p];
}

void expectSameRays(const ProjectionGeometry& is, const ProjectionGeometry& shouldBe) {
    EXPECT_EQ(is.beam, shouldBe.beam);
    ASSERT_EQ(is.views.size(), shouldBe.views.size());
    for (std::size_t n = 0; n < is.views.size(); ++n) {
        const XrayView &a = is.views[n], &b = shouldBe.views[n];
        for (const Vec3& difference :
             {a.source - b.source, a.direction - b.direction, a.origin - b.origin, a.column - b.column, a.row - b.row})
            EXPECT_LT(difference.length(), 1e-9) << "view " << n;  // JSON has all digits
    }
}

CircularOrbit parallelOrbit(int width, int height, int views) {
    CircularOrbit orbit;
    orbit.width = width;
    orbit.height = height;
    orbit.views = views;
    return orbit;
}

class ScanFiles : public ::testing::Test {
  protected:
    static constexpr int kWidth = 24, kHeight = 3, kViews = 6;

    /// Pictures, one for each view. @return their folder
    std::string write(const std::string& name, const Projections& projections) {
        std::filesystem::create_directory(folder / name);
        const std::string path = folder / name;
        writeProjections(path + "/p.exr", projections);
        return path;
    }
    /// A scan of line integrals, which tell which ray they are of.
    ScanOptions plain() {
        ScanOptions options;
        options.projections = {write("plain", numbered(kWidth, kHeight, kViews))};
        return options;
    }
    void expectRefused(ScanOptions options, const std::string& message) {
        expectError<InvalidArgument>([&] { readScan(options); }, message);
    }

    TemporaryFolder folder;
};

bool hasWarning(const Scan& scan, ScanWarning::Kind kind) {
    return std::any_of(scan.found.warnings.begin(), scan.found.warnings.end(),
                       [&](const ScanWarning& warning) { return warning.kind == kind; });
}

bool assumes(const Scan& scan, const std::string& text) {
    return std::any_of(scan.found.assumptions.begin(), scan.found.assumptions.end(),
                       [&](const std::string& assumed) { return assumed.find(text) != std::string::npos; });
}

}  // namespace

TEST_F(ScanFiles, LineIntegralsAreTakenAsTheyAreAndWhatIsNotSaidIsAssumed) {
    const Scan scan = readScan(plain());
    EXPECT_TRUE(scan.complete);
    expectSameValues(scan.projections, numbered(kWidth, kHeight, kViews));
    expectSameRays(scan.geometry, circularGeometry(parallelOrbit(kWidth, kHeight, kViews)));
    EXPECT_EQ(scan.found.format, "pictures");
    EXPECT_TRUE(scan.found.anglesAssumed);
    EXPECT_TRUE(scan.found.pitchAssumed);
    EXPECT_FALSE(scan.found.axis);
    EXPECT_TRUE(scan.found.warnings.empty());
}

TEST_F(ScanFiles, CountsBecomeLineIntegralsByTheMeanOfFrames) {
    const std::size_t size = kWidth * kHeight;
    Projections counts(kWidth, kHeight, kViews), flat(kWidth, kHeight, 2), dark(kWidth, kHeight, 2);
    for (std::size_t p = 0; p < size; ++p)
        for (int n = 0; n < 2; ++n) {
            flat.view(n)[p] = 990.f + 20 * n;
            dark.view(n)[p] = 9.f + 2 * n;
        }
    flat.view(0)[40] = flat.view(1)[40] = 12;  // a dead pixel
    for (std::size_t p = 0; p < counts.values.size(); ++p) counts.values[p] = 100.f + float(p % 700);
    counts.values[5] = 0;  // no photon came through
    ScanOptions options;
    options.projections = {write("counts", counts)};
    options.flat = write("flat", flat);
    options.dark = write("dark", dark);
    const Scan scan = readScan(options);
    const LineIntegrals expected =
        lineIntegrals(counts, std::vector<float>(flat.view(0), flat.view(0) + size), std::vector<float>(size, 10));
    for (std::size_t p = 0; p < counts.values.size(); ++p) {
        const double is = scan.projections.values[p];
        if (p % size == 40) {
            EXPECT_TRUE(std::isnan(is));
        } else if (p != 5) {
            EXPECT_NEAR(is, -std::log((counts.values[p] - 10) / 990), 1e-6) << "float";
        }
    }
    EXPECT_EQ(scan.found.deadPixels, expected.deadPixels);
    EXPECT_EQ(scan.found.deadPixels, 1u);
    EXPECT_EQ(scan.found.rays.notMeasured, std::size_t(kViews));
    EXPECT_EQ(scan.found.rays.saturated, 1u);
}

TEST_F(ScanFiles, FramesMustBeOfTheSameDetector) {
    ScanOptions options = plain();
    options.flat = write("turned", Projections(kHeight, kWidth, 1));
    expectRefused(options, "the flat frame has 3x24 pixels");
    Projections flat(kWidth, kHeight, 1);
    std::fill(flat.values.begin(), flat.values.end(), 1000.f);
    options.flat = write("flat", flat);
    options.dark = options.projections.front();
    EXPECT_NO_THROW(readScan(options));
    options.dark = write("narrow", Projections(kWidth - 1, kHeight, 1));
    expectRefused(options, "the dark frame has 23x3 pixels");
}

TEST_F(ScanFiles, FramesAreRepairedAsProjectionsAre) {
    Projections flat(kWidth, kHeight, 2);
    std::fill(flat.values.begin(), flat.values.end(), 1000.f);
    flat.view(1)[3] = std::numeric_limits<float>::infinity();  // measured in the other frame
    flat.view(0)[4] = flat.view(1)[4] = kNaN;
    ScanOptions options = plain();
    options.flat = write("flat", flat);
    expectRefused(options, "NaN or infinite");
    options.repair = true;
    const Scan scan = readScan(options);
    EXPECT_EQ(scan.found.deadPixels, 1u);
    EXPECT_FLOAT_EQ(scan.projections.values[3], -std::log(numbered(kWidth, kHeight, kViews).values[3] / 1000));
    EXPECT_TRUE(std::isnan(scan.projections.values[4]));
}

TEST_F(ScanFiles, CorrectionsAreThoseOfTheCallsTheyAreMadeOf) {
    ScanOptions options = plain();
    options.scale = 2;
    options.saturation = 100;
    options.ringWindow = 5;
    const Scan scan = readScan(options);
    Projections expected = numbered(kWidth, kHeight, kViews);
    for (float& value : expected.values) value *= 2;
    expected.saturation = 100;
    filterRings(expected, RingFilterOptions{5});
    expectSameValues(scan.projections, expected);
    EXPECT_EQ(scan.projections.saturation, 100);
    EXPECT_EQ(scan.found.rays.saturated, countRays(expected).saturated);
    EXPECT_GT(scan.found.rays.saturated, 0u);
}

TEST_F(ScanFiles, GeometryFileAndOptionsSayTheSame) {
    CircularOrbit orbit = parallelOrbit(kWidth, kHeight, kViews);
    orbit.beam = BeamShape::cone;
    orbit.sourceToAxis = 120;
    orbit.sourceToDetector = 180;
    orbit.arc = 360;
    orbit.firstAngle = 30;
    orbit.pixelWidth = 0.5;
    orbit.pixelHeight = 0.25;
    orbit.center = Vec3(1, 2, 3);
    const ProjectionGeometry expected = circularGeometry(orbit);
    ScanOptions options = plain();
    options.geometry.beam = BeamShape::cone;
    options.geometry.sourceToAxis = 120;
    options.geometry.sourceToDetector = 180;
    options.geometry.firstAngle = 30;
    options.geometry.pitch = DetectorPair{0.5, 0.25};
    options.geometry.center = Vec3(1, 2, 3);
    const Scan scan = readScan(options);
    expectSameRays(scan.geometry, expected);
    EXPECT_FALSE(scan.found.pitchAssumed);
    EXPECT_EQ(pitchOf(scan.geometry)[1], 0.25);
    writeGeometry(folder / "g.json", expected);
    options.geometry = {};
    options.geometry.file = folder / "g.json";
    const Scan byFile = readScan(options);
    expectSameRays(byFile.geometry, expected);
    EXPECT_FALSE(byFile.found.anglesAssumed || byFile.found.pitchAssumed);
    options.geometry.views = 6;
    expectRefused(options, "says where the views are");
}

TEST_F(ScanFiles, TheAxisIsFoundIfAskedTo) {
    const int views = 60;
    const double column = 98.25;
    ScanOptions options;
    options.projections = {write("body", sinogram(lopsidedBody(), 192, column, anglesFrom(0, 180.0 / views, views)))};
    EXPECT_FALSE(readScan(options).found.axis) << "pictures: in the middle unless asked to";
    options.axisSearch = AxisSearch::always;
    const Scan scan = readScan(options);
    ASSERT_TRUE(scan.found.axis);
    EXPECT_NEAR(scan.found.axis->column, column, 0.0142);  // found: 0.0129
    CircularOrbit orbit = parallelOrbit(192, 1, views);
    orbit.axisColumn = scan.found.axis->column;
    expectSameRays(scan.geometry, circularGeometry(orbit));
}

TEST_F(ScanFiles, Hdf5HasItsOwnFramesAnglesAndAxis) {
    const int views = 60, width = 192;
    const double column = 98.25;
    const std::vector<double> angles = anglesFrom(10, 180.0 / views, views);
    const Projections body = sinogram(lopsidedBody(), width, column, angles);
    std::vector<float> counts;
    for (const float value : body.values) counts.push_back(100 + 1000 * std::exp(-value));
    {
        Hdf5File file(folder / "scan.h5");
        const auto frame = [&](const char* name, float value) {
            const std::vector<float> all(width, value);
            file.add(name, {1, 1, hsize_t(width)}, H5T_IEEE_F32LE, H5T_NATIVE_FLOAT, all.data());
        };
        file.add("data", {hsize_t(views), 1, hsize_t(width)}, H5T_IEEE_F32LE, H5T_NATIVE_FLOAT, counts.data());
        frame("data_white", 1100);
        frame("data_dark", 100);
        file.addAngles(angles);
    }
    ScanOptions options;
    options.projections = {folder / "scan.h5"};
    const Scan scan = readScan(options);
    EXPECT_EQ(scan.found.format, "Data Exchange");
    EXPECT_FALSE(scan.found.anglesAssumed);
    EXPECT_LT(rmsDifference(scan.projections, body), 1e-4) << "counts are floats";
    ASSERT_TRUE(scan.found.axis);
    EXPECT_NEAR(scan.found.axis->column, column, 0.0166);  // found: 0.0152
    CircularOrbit orbit = parallelOrbit(width, 1, views);
    orbit.axisColumn = scan.found.axis->column;
    orbit.firstAngle = 10;
    ASSERT_EQ(scan.geometry.views.size(), std::size_t(views));
    const Vec3 turned = scan.geometry.views[7].direction - circularGeometry(orbit).views[7].direction;
    EXPECT_LT(turned.length(), 1e-6) << "angles are stored as floats";
    options.axisSearch = AxisSearch::never;
    EXPECT_FALSE(readScan(options).found.axis);
    options.sinograms = Sinograms::always;
    expectRefused(options, "sinograms: HDF5 files say themselves");
    options.sinograms = Sinograms::automatic;
    options.rows = RowRange{0, 1};
    options.geometry.beam = BeamShape::cone;
    expectRefused(options, "rows: of a cone need `centerRow` as well");
}

TEST_F(ScanFiles, WhatHdf5LacksIsGivenBesideItOrAssumedAloud) {
    const Projections body = sinogram(lopsidedBody(), 192, 95.5, anglesFrom(0, 3, 60));
    const auto writeScan = [&](bool withFlat, bool radians) {
        Hdf5File file(folder / "scan.h5");
        std::vector<float> counts, flat(192, 1000);
        for (const float value : body.values) counts.push_back(1000 * std::exp(-value));
        file.add("data", {60, 1, 192}, H5T_IEEE_F32LE, H5T_NATIVE_FLOAT, counts.data());
        if (withFlat) file.add("data_white", {1, 1, 192}, H5T_IEEE_F32LE, H5T_NATIVE_FLOAT, flat.data());
        std::vector<double> angles = anglesFrom(0, 3, 60);
        for (double& angle : angles) angle *= radians ? kPi / 180 : 1;
        file.addAngles(angles);
    };
    ScanOptions options;
    options.projections = {folder / "scan.h5"};
    options.geometry.axisColumn = 95.5;
    writeScan(true, true);
    const Scan scan = readScan(options);
    EXPECT_LT(rmsDifference(scan.projections, body), 1e-6) << "dark 0, floats";
    EXPECT_TRUE(assumes(scan, "without beam 0 is counted"));
    EXPECT_TRUE(assumes(scan, "taken for radians"));
    EXPECT_TRUE(assumes(scan, "pixels are 1 apart"));
    const Vec3 turned =
        scan.geometry.views[30].direction - circularGeometry(parallelOrbit(192, 1, 60)).views[30].direction;
    EXPECT_LT(turned.length(), 1e-6) << "angles are stored as floats";
    options.geometry.angleUnit = AngleUnit::degrees;
    EXPECT_NEAR(readScan(options).geometry.views[30].direction.y, -std::sin(0.5 * kPi * kPi / 180), 1e-6);
    options.geometry.angleUnit = {};

    writeScan(false, false);
    expectError<IoError>([&] { readScan(options); }, "say it as `flat`: a file, a number, auto");
    Projections frame(192, 1, 1);
    std::fill(frame.values.begin(), frame.values.end(), 1000.f);
    for (const std::string& flat : {write("frame", frame), std::string("1000"), std::string("auto")}) {
        options.flat = flat;
        EXPECT_LT(rmsDifference(readScan(options).projections, body), 1e-6) << flat;
    }
    EXPECT_TRUE(assumes(readScan(options), "without object 1000 is counted"));
    options.flat = "none";
    EXPECT_FLOAT_EQ(readScan(options).projections.values[0], 1000);
    EXPECT_TRUE(hasWarning(readScan(options), ScanWarning::Kind::values)) << "they look like counts";
    options.dark = "3";
    expectRefused(options, "dark: needs `flat` as well");
}

TEST_F(ScanFiles, Hdf5CountsThatAreNotNumbersAreAnErrorOrNotMeasured) {
    {
        Hdf5File file(folder / "scan.h5");
        std::vector<float> counts(6 * 8, 500), flat(8, 1000);
        counts[9] = kNaN;
        counts[20] = std::numeric_limits<float>::infinity();
        counts[30] = 3e38f;
        file.add("data", {6, 1, 8}, H5T_IEEE_F32LE, H5T_NATIVE_FLOAT, counts.data());
        file.add("data_white", {1, 1, 8}, H5T_IEEE_F32LE, H5T_NATIVE_FLOAT, flat.data());
    }
    ScanOptions options;
    options.projections = {folder / "scan.h5"};
    options.geometry.axisColumn = 3.5;
    expectRefused(options, "has 2 values that are NaN or infinite, the first in view 1, row 0, column 1");
    options.repair = true;
    const Scan scan = readScan(options);
    EXPECT_EQ(scan.found.rays.notMeasured, 3u);
    EXPECT_EQ(scan.found.implausible, 1u);
    EXPECT_TRUE(hasWarning(scan, ScanWarning::Kind::implausible));
}

TEST_F(ScanFiles, AnglesMayComeFromAFile) {
    ScanOptions options = plain();
    const std::vector<double> angles = {0, 10, 30, 60, 100, 150};
    std::ofstream(folder / "angles.txt") << "0 10 30\n60, 100, 150\n";
    options.geometry.angles = folder / "angles.txt";
    const Scan scan = readScan(options);
    CircularOrbit orbit = parallelOrbit(kWidth, kHeight, kViews);
    orbit.angles = angles;
    expectSameRays(scan.geometry, circularGeometry(orbit));
    EXPECT_FALSE(scan.found.anglesAssumed);
    options.geometry.arc = 180;
    expectRefused(options, "arc: leave it out if there are `angles`");
    options.geometry.arc = {};
    std::ofstream(folder / "few.txt") << "0 10 30\n60\n";
    options.geometry.angles = folder / "few.txt";
    expectRefused(options, "few.txt' has 4 angles, but the projections have 6 views");
    ScanGeometryOptions alone;  // without projections
    alone.angles = folder / "angles.txt";
    alone.width = kWidth;
    alone.height = kHeight;
    expectSameRays(scanGeometry(alone), circularGeometry(orbit));
}

TEST_F(ScanFiles, RowsOfASinogramAreViews) {
    const Projections body = sinogram(lopsidedBody(), 192, 95.5, anglesFrom(0, 3, 60));
    Projections picture = body;  // one view of 192 x 60 pixels
    picture.height = 60;
    picture.views = 1;
    ScanOptions options;
    options.projections = {write("picture", picture)};
    const Scan scan = readScan(options);
    expectSameValues(scan.projections, body);
    EXPECT_EQ(scan.projections.views, 60);
    expectSameRays(scan.geometry, circularGeometry(parallelOrbit(192, 1, 60)));
    EXPECT_TRUE(assumes(scan, "taken for a sinogram, of 192 detector columns in 60 views"));
    options.geometry.views = 1;
    EXPECT_EQ(readScan(options).projections.height, 60) << "said to be one view";
    options.geometry.views = 60;
    EXPECT_EQ(readScan(options).projections.views, 60);

    // Several sinograms: where the number of views says so, or they are asked for.
    Projections several(24, 6, 3), expected(24, 3, 6);
    for (int row = 0; row < 3; ++row)
        for (int n = 0; n < 6; ++n)
            for (int x = 0; x < 24; ++x)
                several.view(row)[n * 24 + x] = expected.view(n)[row * 24 + x] = float(100 * n + 30 * row + x);
    options.projections = {write("several", several)};
    options.geometry.views = 6;
    expectSameValues(readScan(options).projections, expected);
    options.geometry.views = 0;
    EXPECT_EQ(readScan(options).projections.views, 3) << "one view each";
    options.sinograms = Sinograms::always;
    expectSameValues(readScan(options).projections, expected);
}

TEST_F(ScanFiles, BrokenPixelsAreLeftOutAndSaid) {
    Projections broken = numbered(kWidth, kHeight, kViews);
    broken.view(2)[17] = 1e30f;
    ScanOptions options;
    options.projections = {write("broken", broken)};
    const Scan scan = readScan(options);
    EXPECT_TRUE(std::isnan(scan.projections.view(2)[17]));
    EXPECT_EQ(scan.found.rays.notMeasured, 1u);
    ASSERT_TRUE(hasWarning(scan, ScanWarning::Kind::implausible));
    options.flat = "1000";  // of counts likewise
    EXPECT_EQ(readScan(options).found.implausible, 1u);
}

TEST_F(ScanFiles, OverExposedCountsSayAtMost) {
    Projections counts(kWidth, kHeight, kViews);
    for (std::size_t p = 0; p < counts.values.size(); ++p)
        counts.values[p] = std::min(600.f, 100.f + 5 * float(p % 150));
    ScanOptions options;
    options.projections = {write("counts", counts)};
    options.flat = "1000";
    EXPECT_EQ(readScan(options).found.rays.overexposed, 0u) << "nothing says where floats end";
    options.saturatedAbove = 600;
    const Scan scan = readScan(options);
    EXPECT_EQ(scan.found.rays.overexposed, std::size_t(std::count(counts.values.begin(), counts.values.end(), 600.f)));
    EXPECT_EQ(scan.projections.boundOf(149), RayBound::atMost);
    EXPECT_EQ(scan.projections.boundOf(0), RayBound::none);
    options.flat.clear();  // of line integrals it is the same as the saturation
    EXPECT_EQ(readScan(options).projections.boundOf(149), RayBound::atLeast);
    options.saturation = 600;
    expectRefused(options, "saturatedAbove: of line integrals it is `saturation`");
}

TEST_F(ScanFiles, WhatIsHardlyMeantIsSaid) {
    ScanOptions options = plain();
    options.geometry.beam = BeamShape::cone;
    options.geometry.sourceToAxis = 180;
    options.geometry.sourceToDetector = 120;
    const Scan swapped = readScan(options);
    ASSERT_EQ(swapped.found.warnings.size(), 1u);
    EXPECT_EQ(swapped.found.warnings[0].kind, ScanWarning::Kind::detectorBeforeAxis);
    EXPECT_NE(swapped.found.warnings[0].message.find("(120)"), std::string::npos) << swapped.found.warnings[0].message;

    ScanOptions dead;
    Projections flat(kWidth, kHeight, 1);
    for (std::size_t p = 0; p < flat.values.size(); ++p) flat.values[p] = p < 20 ? 1000 : 0;
    dead.projections = {write("counts", numbered(kWidth, kHeight, kViews))};
    dead.flat = write("flat", flat);
    EXPECT_TRUE(hasWarning(readScan(dead), ScanWarning::Kind::deadPixels));
}

TEST_F(ScanFiles, PixelsElsewhereThanInTheGeometryAreSaid) {
    if (!hasItk()) GTEST_SKIP() << "this build has no ITK, which writes MetaImage";
    writeProjections(folder / "p.mha", numbered(kWidth, kHeight, kViews), DetectorPair{0.1, 0.1});
    writeGeometry(folder / "g.json", circularGeometry(parallelOrbit(kWidth, kHeight, kViews)));
    ScanOptions options;
    options.projections = {folder / "p.mha"};
    EXPECT_NEAR(pitchOf(readScan(options).geometry)[0], 0.1, 1e-12) << "the file says so";
    options.geometry.file = folder / "g.json";
    EXPECT_TRUE(hasWarning(readScan(options), ScanWarning::Kind::pixelPitch));
}

TEST_F(ScanFiles, ReadingStopsWhenAskedTo) {
    const Scan scan = readScan(plain(), [](const std::string&, double) { return false; });
    EXPECT_FALSE(scan.complete);
    EXPECT_TRUE(scan.projections.values.empty() && scan.geometry.views.empty());
}

TEST_F(ScanFiles, WhatCannotBeAScanIsRefused) {
    const auto with = [this](const auto& change) {
        ScanOptions options = plain();
        change(options);
        return options;
    };
    expectRefused({}, "projections: give at least one");
    expectRefused(with([](ScanOptions& o) { o.dark = "dark.exr"; }), "dark: needs `flat` as well");
    expectRefused(with([](ScanOptions& o) { o.rows = RowRange{0, 1}; }), "rows: only of HDF5");
    expectRefused(with([](ScanOptions& o) { o.scale = 0; }), "scale 0: must be positive");
    expectRefused(with([](ScanOptions& o) { o.saturation = kNaN; }), "saturation nan: must be positive");
    expectRefused(with([](ScanOptions& o) { o.ringWindow = 4; }), "window");
    expectRefused(with([](ScanOptions& o) { o.geometry.width = -1; }), "width -1: must be at least 0");
    expectRefused(with([](ScanOptions& o) { o.geometry.pitch = DetectorPair{1, 0}; }), "pitch 0: must be positive");
    expectRefused(with([](ScanOptions& o) { o.geometry.arc = 0; }), "arc");
    expectRefused(with([](ScanOptions& o) { o.geometry.beam = BeamShape::cone; }), "sourceToAxis 0");
    expectRefused(with([](ScanOptions& o) { o.geometry.views = 5; }), "the geometry has 5 views");
    expectRefused(with([](ScanOptions& o) {
                      o.geometry.beam = BeamShape::cone;
                      o.geometry.sourceToAxis = o.geometry.sourceToDetector = 100;
                      o.axisSearch = AxisSearch::always;
                  }),
                  "axisSearch");
    expectRefused(with([](ScanOptions& o) {
                      o.geometry.axisColumn = 10;
                      o.axisSearch = AxisSearch::always;
                  }),
                  "`axisColumn` says where the axis is");
    expectError<IoError>([&] { readScan(with([](ScanOptions& o) { o.geometry.file = "missing.json"; })); },
                         "missing.json");
    ScanOptions nothing;
    Projections unmeasured(kWidth, kHeight, kViews);
    std::fill(unmeasured.values.begin(), unmeasured.values.end(), kNaN);
    nothing.projections = {write("unmeasured", unmeasured)};
    nothing.repair = true;
    expectRefused(nothing, "no ray was measured");
}

TEST(ScanGeometry, WithoutProjectionsAllMustBeSaid) {
    ScanGeometryOptions options;
    options.views = 12;
    options.width = 20;
    expectError<InvalidArgument>([&] { scanGeometry(options); }, "height 0");
    options.height = 10;
    expectSameRays(scanGeometry(options), circularGeometry(parallelOrbit(20, 10, 12)));
    options.views = 0;
    expectError<InvalidArgument>([&] { scanGeometry(options); }, "views 0");
}
