// RTK's files describe each view twice: by angles and distances, which is what is read, and by the matrix that takes
// points of the world to the detector. Here the matrix is the independent answer.
#include "raysweep/scan/rtk_geometry.h"

#include "raysweep/scan/geometry_io.h"

#include <array>
#include <random>
#include <sstream>

#include "support/temporary_folder.h"
#include "support/volume_files.h"
#include "unit/scan/ct_fixture.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

using Matrix4 = std::array<std::array<double, 4>, 4>;

Matrix4 operator*(const Matrix4& a, const Matrix4& b) {
    Matrix4 product{};
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            for (int k = 0; k < 4; ++k) product[i][j] += a[i][k] * b[k][j];
    return product;
}

struct RtkView {
    double sid, sdd, gantry, projectionX, projectionY, outOfPlane, inPlane, sourceX, sourceY;
};

/// The matrix as RTK's documentation defines it ("3D projection geometry", Final matrix and Parallel geometry); the
/// last row is not used.
Matrix4 documentedMatrix(const RtkView& v) {
    const auto c = [](double degrees) { return std::cos(-degrees * kPi / 180); };
    const auto s = [](double degrees) { return std::sin(-degrees * kPi / 180); };
    const double i = v.inPlane, o = v.outOfPlane, g = v.gantry;
    const Matrix4 rotation = Matrix4{{{c(i), -s(i), 0, 0}, {s(i), c(i), 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}} *
                             Matrix4{{{1, 0, 0, 0}, {0, c(o), -s(o), 0}, {0, s(o), c(o), 0}, {0, 0, 0, 1}}} *
                             Matrix4{{{c(g), 0, s(g), 0}, {0, 1, 0, 0}, {-s(g), 0, c(g), 0}, {0, 0, 0, 1}}};
    if (v.sdd == 0)
        return Matrix4{{{1, 0, 0, -v.projectionX}, {0, 1, 0, -v.projectionY}, {0, 0, 0, 1}, {0, 0, 0, 0}}} * rotation;
    const Matrix4 shift = {{{1, 0, v.sourceX - v.projectionX, 0}, {0, 1, v.sourceY - v.projectionY, 0}, {0, 0, 1, 0}}};
    const Matrix4 magnify = {{{-v.sdd, 0, 0, 0}, {0, -v.sdd, 0, 0}, {0, 0, 1, -v.sid}, {0, 0, 0, 0}}};
    const Matrix4 source = {{{1, 0, 0, -v.sourceX}, {0, 1, 0, -v.sourceY}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
    return shift * magnify * source * rotation;
}

std::string xml(const std::string& inside) {
    return "<?xml version=\"1.0\"?>\n<!DOCTYPE RTKGEOMETRY>\n<RTKThreeDCircularGeometry version=\"3\">\n" + inside +
           "</RTKThreeDCircularGeometry>\n";
}

std::string tag(const std::string& name, double value) {
    std::ostringstream text;
    text.precision(15);
    text << "<" << name << ">" << value << "</" << name << ">\n";
    return text.str();
}

std::string projectionXml(const RtkView& v, bool withMatrix) {
    std::ostringstream text;
    text.precision(15);
    text << "<Projection>\n"
         << tag("GantryAngle", v.gantry) << tag("SourceToIsocenterDistance", v.sid)
         << tag("SourceToDetectorDistance", v.sdd) << tag("SourceOffsetX", v.sourceX) << tag("SourceOffsetY", v.sourceY)
         << tag("ProjectionOffsetX", v.projectionX) << tag("ProjectionOffsetY", v.projectionY)
         << tag("InPlaneAngle", v.inPlane) << tag("OutOfPlaneAngle", v.outOfPlane);
    if (withMatrix) {
        text << "<Matrix>\n";
        const Matrix4 matrix = documentedMatrix(v);
        for (int r = 0; r < 3; ++r) {
            for (int c = 0; c < 4; ++c) text << "  " << matrix[r][c];
            text << "\n";
        }
        text << "</Matrix>\n";
    }
    text << "</Projection>\n";
    return text.str();
}

RtkDetector someDetector() {
    return {400, 300, DetectorPair{0.5, 0.75}, DetectorPair{-101, -97.5}};
}

/// Where the ray through a point of the world meets the detector: columns and rows, from the view alone.
std::array<double, 2> seenAt(const XrayView& view, BeamShape beam, const Vec3& point) {
    const Vec3 along = beam == BeamShape::cone ? point - view.source : view.direction;
    // point + t along = origin + x column + y row, by Cramer's rule
    const Vec3 offset = point - view.origin;
    const double determinant = view.column.dot(view.row.cross(along));
    return {offset.dot(view.row.cross(along)) / determinant, view.column.dot(offset.cross(along)) / determinant};
}

void expectMatrix(const ProjectionGeometry& geometry, std::size_t n, const Matrix4& matrix,
                  const RtkDetector& detector) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> place(-60, 60);
    for (int k = 0; k < 20; ++k) {
        const Vec3 p(place(random), place(random), place(random));
        double image[3];
        for (int r = 0; r < 3; ++r)
            image[r] = matrix[r][0] * p.x + matrix[r][1] * p.y + matrix[r][2] * p.z + matrix[r][3];
        const auto [x, y] = seenAt(geometry.views[n], geometry.beam, p);
        // Doubles on the one side, 15 digits on the other.
        EXPECT_NEAR((*detector.origin)[0] + x * (*detector.spacing)[0], image[0] / image[2], 1e-8);
        EXPECT_NEAR((*detector.origin)[1] + y * (*detector.spacing)[1], image[1] / image[2], 1e-8);
    }
}

}  // namespace

TEST(RtkGeometry, RaysMeetTheDetectorWhereTheMatrixSays) {
    std::mt19937 random(2);
    const auto between = [&](double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random);
    };
    for (const bool parallel : {false, true}) {
        std::vector<RtkView> views;
        std::string text;
        for (int n = 0; n < 12; ++n) {
            views.push_back({between(500, 1000), parallel ? 0 : between(1100, 1600), between(0, 360), between(-90, 90),
                             between(-90, 90), between(-40, 40), between(-180, 180), parallel ? 0 : between(-50, 50),
                             parallel ? 0 : between(-50, 50)});
            text += projectionXml(views.back(), n % 2 == 0);
        }
        const ProjectionGeometry geometry = geometryFromRtk(xml(text), someDetector());
        EXPECT_EQ(geometry.beam, parallel ? BeamShape::parallel : BeamShape::cone);
        EXPECT_EQ(geometry.width, 400);
        EXPECT_EQ(geometry.height, 300);
        ASSERT_EQ(geometry.views.size(), views.size());
        for (std::size_t n = 0; n < views.size(); ++n)
            expectMatrix(geometry, n, documentedMatrix(views[n]), someDetector());
    }
}

// Numbers that RTK itself wrote: the two views of the example in its documentation.
TEST(RtkGeometry, AgreesWithMatricesThatRtkWrote) {
    const std::string text =
        xml(tag("SourceToIsocenterDistance", 1000) + tag("SourceToDetectorDistance", 1536) + "<Projection>" +
            tag("GantryAngle", 271.847274780273) + tag("ProjectionOffsetX", -117.056503295898) +
            tag("ProjectionOffsetY", -1.01195001602173) + "</Projection><Projection>" +
            tag("GantryAngle", 271.852905273438) + tag("ProjectionOffsetX", -117.056831359863) +
            tag("ProjectionOffsetY", -1.01187002658844) + "</Projection>");
    const ProjectionGeometry geometry = geometryFromRtk(text, someDetector());
    ASSERT_EQ(geometry.views.size(), 2u);
    const Matrix4 first = {{{-166.5093078829, 0, -1531.42837748039, -117056.503295898},
                            {-1.01142410874151, -1536, 0.0326206557691505, -1011.95001602173},
                            {-0.999480303105996, 0, 0.0322354417240802, -1000}}};
    const Matrix4 second = {{{-166.660129424325, 0, -1531.41199650136, -117056.831359863},
                             {-1.01134095059569, -1536, 0.0327174625589984, -1011.87002658844},
                             {-0.999477130482326, 0, 0.0323336611415466, -1000}}};
    expectMatrix(geometry, 0, first, someDetector());
    expectMatrix(geometry, 1, second, someDetector());
}

TEST(RtkGeometry, AtAngleZeroSourceIsAtPlusZAndPixelsCountAlongXAndY) {
    const std::string text = xml(tag("SourceToIsocenterDistance", 1000) + tag("SourceToDetectorDistance", 1500) +
                                 "<Projection>" + tag("GantryAngle", 0) + "</Projection>");
    const XrayView view = geometryFromRtk(text, {3, 5, DetectorPair{2, 4}, {}}).views[0];
    EXPECT_EQ(view.source, Vec3(0, 0, 1000));
    EXPECT_EQ(view.origin, Vec3(-2, -8, -500)) << "without an origin the middle of the detector is at 0";
    EXPECT_EQ(view.column, Vec3(2, 0, 0));
    EXPECT_EQ(view.row, Vec3(0, 4, 0));
}

TEST(RtkGeometry, ValuesHoldUntilAnotherOneIsGiven) {
    const std::string text =
        xml(tag("SourceToIsocenterDistance", 1000) + tag("SourceToDetectorDistance", 1500) + "<Projection>" +
            tag("GantryAngle", 0) + tag("SourceToIsocenterDistance", 800) + tag("CollimationUInf", 3) +
            "</Projection><Projection>" + tag("GantryAngle", 0) + "</Projection>");
    const ProjectionGeometry geometry = geometryFromRtk(text, someDetector());
    EXPECT_EQ(geometry.views[0].source, Vec3(0, 0, 800));
    EXPECT_EQ(geometry.views[1].source, Vec3(0, 0, 800));
}

TEST(RtkGeometry, MatrixThatContradictsTheAnglesIsRefused) {
    const RtkView view{1000, 1500, 30, 5, -7, 2, 1, 3, 4};
    std::string text = projectionXml(view, true);
    RtkView other = view;
    other.gantry += 0.1;  // 0.1 degrees at 1000 from the axis' shadow: pixels, by far more than rounding
    const std::size_t angle = text.find("<GantryAngle>30<");
    ASSERT_NE(angle, std::string::npos);
    text.replace(angle, 15, "<GantryAngle>30.1");
    expectError<InvalidArgument>([&] { geometryFromRtk(xml(projectionXml(view, true) + text), someDetector()); },
                                 "view 1: <Matrix> contradicts the angles and distances");
}

TEST(RtkGeometry, FilesThatAreNotRtksOrNotWholeAreRefused) {
    const auto refuses = [](const std::string& text, const std::string& message) {
        expectError<IoError>([&] { geometryFromRtk(text, someDetector()); }, message);
    };
    const std::string good = projectionXml({1000, 1500, 30, 5, -7, 2, 1, 3, 4}, true);
    EXPECT_NO_THROW(geometryFromRtk(xml(good), someDetector()));
    refuses("", "it is not valid XML");
    refuses("<a></a>", "its root is <a>");
    refuses(xml(good).substr(0, 300), "it is not valid XML, line ");
    refuses("<RTKThreeDCircularGeometry version=\"1\"/>", "its version is '1'");
    refuses(xml(tag("SourceToIsocentreDistance", 1000) + good), "<SourceToIsocentreDistance> is not known");
    refuses(xml("<Projection><GantryAngle>ninety</GantryAngle></Projection>"), "view 0, <GantryAngle>: 'ninety'");
    refuses(xml("<Projection><GantryAngle></GantryAngle></Projection>"), "<GantryAngle> must hold one number");
    refuses(xml("<Projection><GantryAngle>nan</GantryAngle></Projection>"), "is no finite number");
    refuses(xml("<Projection><GantryAngle>1</GantryAngle><GantryAngle>2</GantryAngle></Projection>"),
            "view 0: <GantryAngle> is given twice");
    refuses(xml(tag("SourceToDetectorDistance", 9) + tag("SourceToDetectorDistance", 8) + good),
            "<SourceToDetectorDistance> is given twice");
    refuses(xml("<Projection><Matrix>1 2 3</Matrix></Projection>"), "<Matrix> must hold 3 x 4 numbers");
}

TEST(RtkGeometry, GeometriesThatCannotBeUsedAreRefused) {
    const auto refuses = [](const std::string& text, const std::string& message) {
        expectError<InvalidArgument>([&] { geometryFromRtk(text, someDetector()); }, message);
    };
    const std::string cone = projectionXml({1000, 1500, 30, 5, -7, 2, 1, 3, 4}, false);
    const std::string parallel = projectionXml({1000, 0, 30, 5, -7, 2, 1, 0, 0}, false);
    refuses(xml(tag("RadiusCylindricalDetector", 1536) + cone), "only flat detectors (0) are known");
    EXPECT_NO_THROW(geometryFromRtk(xml(tag("RadiusCylindricalDetector", 0) + cone), someDetector()));
    refuses(xml(cone + parallel), "view 1: SourceToDetectorDistance is 0 in some views");
    refuses(xml(""), "the geometry has no views");
    expectError<InvalidArgument>(
        [&] {
            geometryFromRtk(xml(cone), {400, 300, {}, {}});
        },
        "say nothing about the detector's pixels");
    expectError<InvalidArgument>(
        [&] {
            geometryFromRtk(xml(cone), {400, 300, DetectorPair{0, 1}, {}});
        },
        "the pixel size must be finite and not 0");
}

TEST(RtkGeometry, IsReadByItsExtension) {
    const TemporaryFolder folder;
    writeFile(folder / "g.xml", xml(projectionXml({1000, 1500, 30, 5, -7, 2, 1, 3, 4}, true)));
    EXPECT_EQ(readGeometry(folder / "g.xml", 400, 300, DetectorPair{0.5, 0.5}).views.size(), 1u);
    expectError<InvalidArgument>([&] { readGeometry(folder / "g.xml"); }, "g.xml': RTK's geometries say nothing");
}
