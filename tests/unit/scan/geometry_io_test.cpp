// Geometries come back from JSON bit by bit; JSON that is not what it must be is refused by name.
#include "raysweep/scan/geometry_io.h"

#include "raysweep/camera/projections.h"

#include "raysweep/scan/geometry_json.h"

#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "support/source_folder.h"
#include "support/temporary_folder.h"
#include "support/volume_files.h"
#include "unit/scan/ct_fixture.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

CircularOrbit someOrbit(BeamShape beam) {
    CircularOrbit orbit;
    orbit.beam = beam;
    orbit.sourceToAxis = 500.1;
    orbit.sourceToDetector = 1000.7;
    orbit.views = 7;
    orbit.firstAngle = 11;
    orbit.arc = -200;
    orbit.width = 20;
    orbit.height = 10;
    orbit.pixelWidth = 0.3;
    orbit.pixelHeight = 0.7;
    orbit.axisColumn = 8.25;
    orbit.centerRow = 4;
    orbit.center = Vec3(1, 2, 3);
    return orbit;
}

void expectSame(const ProjectionGeometry& a, const ProjectionGeometry& b) {
    EXPECT_EQ(a.beam, b.beam);
    EXPECT_EQ(a.width, b.width);
    EXPECT_EQ(a.height, b.height);
    ASSERT_EQ(a.views.size(), b.views.size());
    for (std::size_t n = 0; n < a.views.size(); ++n) {
        EXPECT_EQ(a.views[n].source, b.views[n].source);
        EXPECT_EQ(a.views[n].direction, b.views[n].direction);
        EXPECT_EQ(a.views[n].origin, b.views[n].origin);
        EXPECT_EQ(a.views[n].column, b.views[n].column);
        EXPECT_EQ(a.views[n].row, b.views[n].row);
    }
}

const std::string kView = R"({"direction": [1,0,0], "origin": [0,0,0], "column": [0,1,0], "row": [0,0,1]})";

/// A file that is right, with one part exchanged.
std::string jsonWith(const std::string& part = "", const std::string& other = "") {
    std::string text = R"({"format": "raysweep-geometry", "version": 1, "beam": "parallel",
        "detector": {"width": 4, "height": 3}, "views": [)" +
                       kView + ", " + kView + "]}";
    if (!part.empty()) {
        const std::size_t at = text.rfind(part);
        EXPECT_NE(at, std::string::npos) << part;
        text.replace(at, part.size(), other);
    }
    return text;
}

}  // namespace

TEST(GeometryFile, JsonRoundTripKeepsEveryBit) {
    const TemporaryFolder folder;
    for (const BeamShape beam : {BeamShape::cone, BeamShape::parallel}) {
        const ProjectionGeometry written = circularGeometry(someOrbit(beam));
        writeGeometry(folder / "g.json", written);
        expectSame(readGeometry(folder / "g.json"), written);
    }
}

TEST(GeometryFile, CircularMeansTheSameAsCircularGeometry) {
    const std::string start = R"({"format": "raysweep-geometry", "version": 1, "beam": ")";
    const std::string fields = R"("views": 7, "firstAngle": 11, "arc": -200, "pixelWidth": 0.3, "pixelHeight": 0.7,
        "axisColumn": 8.25, "centerRow": 4, "center": [1, 2, 3])";
    const std::string detector = R"(", "detector": {"width": 20, "height": 10}, "circular": {)";
    expectSame(geometryFromJson(start + "cone" + detector + R"("sourceToAxis": 500.1, "sourceToDetector": 1000.7, )" +
                                fields + "}}"),
               circularGeometry(someOrbit(BeamShape::cone)));
    expectSame(geometryFromJson(start + "parallel" + detector + fields + "}}"),
               circularGeometry(someOrbit(BeamShape::parallel)));
    expectError<IoError>([&] { geometryFromJson(start + "cone" + detector + fields + "}}"); },
                         "'circular.sourceToAxis' is missing");
    expectError<IoError>(
        [&] { geometryFromJson(start + "parallel" + detector + R"("sourceToAxis": 5, )" + fields + "}}"); },
        "'circular.sourceToAxis' is not known here");
    expectError<InvalidArgument>(
        [&] {
            geometryFromJson(start + "parallel" + detector +
                             R"("views": 0, "arc": 180, "pixelWidth": 1, "pixelHeight": 1}})");
        },
        "views 0: must be 1 to 1048576");
    expectError<InvalidArgument>(
        [&] {
            geometryFromJson(start + "parallel" + detector +
                             R"("views": 2147483647, "arc": 180, "pixelWidth": 1, "pixelHeight": 1}})");
        },
        "views 2147483647: must be 1 to 1048576");  // not as many as fit into memory
}

TEST(GeometryFile, JsonThatIsNotAsDescribedIsRefusedByKey) {
    EXPECT_EQ(geometryFromJson(jsonWith()).views.size(), 2u) << "the others differ from this in one thing each";
    const auto refuses = [](const std::string& part, const std::string& other, const std::string& message) {
        expectError<IoError>([&] { geometryFromJson(jsonWith(part, other)); }, message);
    };
    refuses("\"beam\": \"parallel\",", "", "'beam' is missing");
    refuses("parallel", "fan", "'beam' must be \"cone\" or \"parallel\"");
    refuses("raysweep-geometry", "other", "'format' must be \"raysweep-geometry\"");
    refuses("\"version\": 1", "\"version\": 2", "its version is 2");
    refuses("\"version\": 1", "\"version\": 1.5", "'version' must be a whole number");
    refuses("\"width\": 4", "\"width\": 4.0", "'detector.width' must be a whole number");
    refuses("\"width\": 4", "\"width\": 4e10", "'detector.width' must be a whole number");
    refuses("\"width\": 4", "\"width\": 4, \"depth\": 1", "'detector.depth' is not known here");
    refuses("\"width\": 4", "\"width\": 4, \"width\": 5", "'width' is given twice");
    refuses("{\"width\": 4, \"height\": 3}", "[4, 3]", "detector must be an object");
    refuses("\"row\"", "\"rwo\"", "'views[1].row' is missing");
    refuses("\"row\"", "\"source\": [0,0,0], \"row\"", "'views[1].source' is not known here");
    refuses("[0,0,1]", "[0,0]", "'views[1].row' must be an array of three numbers");
    refuses("[0,0,1]", "[0,0,\"1\"]", "'views[1].row' must be an array of three numbers");
    refuses("\"views\"", "\"extra\": 1, \"views\"", "'extra' is not known here");
    refuses("\"views\"", "\"circular\": {}, \"views\"", "has both");
    refuses("\"views\"", "\"view\"", "has neither");
    refuses("]}", "]", "it is not valid JSON");
    expectError<IoError>([] { geometryFromJson("[1]"); }, "the file must be an object");
    expectError<IoError>([] { geometryFromJson(""); }, "it is not valid JSON");
}

TEST(GeometryFile, ViewsThatMakeNoSenseAreRefusedByNumber) {
    expectError<InvalidArgument>([] { geometryFromJson(jsonWith("[0,0,1]", "[0,2,0]")); },
                                 "view 1: the detector has no area");
    expectError<InvalidArgument>([] { geometryFromJson(jsonWith("\"direction\": [1,0,0]", "\"direction\": [0,1,0]")); },
                                 "view 1: the rays run within the detector's plane");
    expectError<InvalidArgument>([] { geometryFromJson(jsonWith("\"width\": 4", "\"width\": 0")); }, "0x3 pixels");
    expectError<InvalidArgument>([] { geometryFromJson(jsonWith(kView + ", " + kView, "")); }, "no views");
}

TEST(GeometryFile, ExamplesInTheDocumentationAreRead) {
    std::ifstream in(test::sourceFolder() + "/docs/ct.md");
    std::string example;
    std::vector<std::string> examples;
    bool inside = false;
    for (std::string line; std::getline(in, line);) {
        if (line.rfind("```", 0) == 0) {
            if (inside) examples.push_back(example);
            inside = line == "```json";
            example.clear();
        } else if (inside) {
            example += line + "\n";
        }
    }
    ASSERT_EQ(examples.size(), 2u);
    CircularOrbit orbit;  // what the first example says of its one view
    orbit.beam = BeamShape::cone;
    orbit.sourceToAxis = 500;
    orbit.sourceToDetector = 1000;
    orbit.views = 1;
    orbit.width = 512;
    orbit.height = 384;
    orbit.pixelWidth = orbit.pixelHeight = 0.4;
    const XrayView read = geometryFromJson(examples[0]).views[0], meant = circularGeometry(orbit).views[0];
    EXPECT_EQ(read.source, meant.source);
    EXPECT_LT((read.pixel(511, 383) - meant.pixel(511, 383)).length(), 1e-9);
    EXPECT_LT((read.origin - meant.origin).length(), 1e-9);
    EXPECT_EQ(geometryFromJson(examples[1]).views.size(), 181u);
}

TEST(GeometryFile, ErrorsNameTheFile) {
    const TemporaryFolder folder;
    expectError<IoError>([&] { readGeometry(folder / "none.json"); }, "none.json': there is no such file");
    expectError<IoError>([&] { readGeometry(folder / "g.txt"); }, "'.txt' is not known");
    writeFile(folder / "g.json", jsonWith("\"beam\": \"parallel\",", ""));
    expectError<IoError>([&] { readGeometry(folder / "g.json"); }, "g.json': 'beam' is missing");
    writeFile(folder / "g.json", jsonWith("[0,0,1]", "[0,2,0]"));
    expectError<InvalidArgument>([&] { readGeometry(folder / "g.json"); }, "g.json': view 1");
}

TEST(GeometryFile, SingularGeometryIsNotWritten) {
    const TemporaryFolder folder;
    ProjectionGeometry geometry = circularGeometry(someOrbit(BeamShape::cone));
    geometry.views[3].source.x = std::numeric_limits<double>::quiet_NaN();
    expectError<InvalidArgument>([&] { writeGeometry(folder / "g.json", geometry); }, "view 3");
    EXPECT_TRUE(folder.isEmpty());
}

TEST(GeometryFile, DisagreementWithTheImagesNamesBothNumbers) {
    const ProjectionGeometry geometry = circularGeometry(someOrbit(BeamShape::cone));
    EXPECT_NO_THROW(requireMatching(geometry, Projections(20, 10, 7)));
    expectError<InvalidArgument>([&] { requireMatching(geometry, Projections(20, 10, 8)); },
                                 "the geometry has 7 views, but the projections have 8");
    expectError<InvalidArgument>([&] { requireMatching(geometry, Projections(21, 10, 7)); },
                                 "20 detector columns, but the projections have 21");
    expectError<InvalidArgument>([&] { requireMatching(geometry, Projections(20, 9, 7)); }, "10 detector rows");
}
