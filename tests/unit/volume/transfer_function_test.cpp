#include "raysweep/volume/transfer_function.h"

#include "raysweep/core/error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "support/temporary_folder.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// What reading a file with this text complains about.
std::string complaintAbout(const std::string& text) {
    const TemporaryFolder folder;
    const std::string path = folder / "table.json";
    std::ofstream(path) << text;
    try {
        readTransferFunction(path);
    } catch (const IoError& e) {
        EXPECT_NE(std::string(e.what()).find(path), std::string::npos) << e.what();
        return e.what();
    }
    return "no error";
}

void expectComplaint(const std::string& text, const std::string& part) {
    const std::string complaint = complaintAbout(text);
    EXPECT_NE(complaint.find(part), std::string::npos) << text << ": " << complaint;
}

}  // namespace

TEST(TransferFunction, RampIsZeroThenLinearThenConstant) {
    const TransferFunction ramp = rampFunction(-2, 6, 0.8);
    for (const double value : {-1e30, -3.0, -2.0}) EXPECT_EQ(evaluate(ramp, value).opacity, 0) << value;
    for (const double value : {-1.0, 0.0, 2.0, 5.5})
        EXPECT_DOUBLE_EQ(evaluate(ramp, value).opacity, 0.8 * (value + 2) / 8) << value;
    for (const double value : {6.0, 7.0, 1e30}) EXPECT_EQ(evaluate(ramp, value).opacity, 0.8) << value;
    EXPECT_EQ(evaluate(rampFunction(0, 1), 1).opacity, 0.99);
    EXPECT_FALSE(ramp.coloured);
}

TEST(TransferFunction, TableIsLinearBetweenItsPointsAndConstantBeyond) {
    const TransferFunction table{{{1, 0.2, Color(0, 0.5f, 1)}, {3, 0.6, Color(1, 0.5f, 0)}, {3, 0.1, grey(0.25f)}},
                                 true};
    table.validate();
    EXPECT_EQ(evaluate(table, 0).opacity, 0.2);
    EXPECT_EQ(evaluate(table, 1).opacity, 0.2);
    EXPECT_DOUBLE_EQ(evaluate(table, 1.5).opacity, 0.3);
    EXPECT_EQ(evaluate(table, 1.5).color, Color(0.25f, 0.5f, 0.75f));
    EXPECT_NEAR(evaluate(table, std::nextafter(3.0, 0.0)).opacity, 0.6, 1e-12);
    // Two points with one value are a step; there and beyond, the later one counts.
    EXPECT_EQ(evaluate(table, 3).opacity, 0.1);
    EXPECT_EQ(evaluate(table, 9).color, grey(0.25f));
}

TEST(TransferFunction, ExtinctionGivesTheOpacityOverAnEdge) {
    for (const double edge : {1e-6, 0.25, 3e5})
        for (const double opacity : {0.0, 1e-12, 0.1, 0.5, 0.99, kMostOpaque}) {
            const double extinction = extinctionFromOpacity(opacity, edge);
            EXPECT_NEAR(-std::expm1(-extinction * edge), opacity, 1e-15 + 1e-12 * opacity) << opacity;
        }
    EXPECT_EQ(extinctionFromOpacity(1, 2), extinctionFromOpacity(kMostOpaque, 2));
    EXPECT_NEAR(extinctionFromOpacity(1, 2) * 2, 9.2103, 1e-4);  // -ln(0.0001)
}

TEST(TransferFunction, RefusesRampsWithoutMeaning) {
    EXPECT_THROW(rampFunction(1, 1), InvalidArgument);
    EXPECT_THROW(rampFunction(2, 1), InvalidArgument);
    EXPECT_THROW(rampFunction(kNan, 1), InvalidArgument);
    EXPECT_THROW(rampFunction(0, kNan), InvalidArgument);
    EXPECT_THROW(rampFunction(-kInfinity, 1), InvalidArgument);
    EXPECT_THROW(rampFunction(0, kInfinity), InvalidArgument);
    for (const double opacity : {0.0, -0.1, 1.001, kNan, kInfinity})
        EXPECT_THROW(rampFunction(0, 1, opacity), InvalidArgument) << opacity;
    EXPECT_NO_THROW(rampFunction(0, 1, 1));
}

TEST(TransferFunction, RefusesTablesWithoutMeaning) {
    EXPECT_THROW(TransferFunction().validate(), InvalidArgument);
    EXPECT_THROW((TransferFunction{{{kNan, 0.5}}, false}.validate()), InvalidArgument);
    EXPECT_THROW((TransferFunction{{{0, kNan}}, false}.validate()), InvalidArgument);
    EXPECT_THROW((TransferFunction{{{0, 0.5, Color(0, 1.5f, 0)}}, true}.validate()), InvalidArgument);
    // A colour that is not meant may be anything.
    EXPECT_NO_THROW((TransferFunction{{{0, 0.5, Color(0, 1.5f, 0)}}, false}.validate()));
}

TEST(TransferFunction, FilesAreReadAndWrittenAlike) {
    const TemporaryFolder folder;
    const std::string path = folder / "table.json";
    const TransferFunction table{{{-1000, 0, Color(0.1f, 0.2f, 0.3f)}, {3.25, 1, Color(1, 1, 0)}}, true};
    std::ofstream(path) << toJson(table);
    const TransferFunction read = readTransferFunction(path);
    ASSERT_EQ(read.points.size(), 2u);
    EXPECT_TRUE(read.coloured);
    for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(read.points[i].value, table.points[i].value);
        EXPECT_EQ(read.points[i].opacity, table.points[i].opacity);
        EXPECT_EQ(read.points[i].color, table.points[i].color);
    }
    std::ofstream(path) << R"([{"value": 0, "opacity": 0}, {"opacity": 1, "value": 2e-3}])";
    EXPECT_FALSE(readTransferFunction(path).coloured);
    EXPECT_EQ(evaluate(readTransferFunction(path), 1e-3).opacity, 0.5);
}

TEST(TransferFunction, FilesWithErrorsAreRefusedWithFilePointAndBound) {
    const std::string good = R"({"value": 0, "opacity": 0.5},)";
    EXPECT_THROW(readTransferFunction("missing.json"), IoError);
    EXPECT_THROW(readTransferFunction("."), IoError);
    expectComplaint("", "it is not valid JSON");
    expectComplaint("[{\"value\": 1,\n \"opacity\" 0.5}]", "it is not valid JSON: parse error at line 2");
    expectComplaint(R"([{"value": 1e999, "opacity": 0.5}])", "it is not valid JSON");
    expectComplaint("{}", "a list of points is needed");
    expectComplaint("[]", "at least one point");
    expectComplaint("[" + good + "3]", "point 2: 3 is no object");
    expectComplaint("[" + good + R"({"opacity": 1}])", "point 2: there is no \"value\"");
    expectComplaint("[" + good + R"({"value": 1}])", "point 2: there is no \"opacity\"");
    expectComplaint("[" + good + R"({"value": "x", "opacity": 1}])", "point 2: \"value\" is \"x\", not a number");
    expectComplaint("[" + good + R"({"value": 1, "opacity": 1.5}])", "point 2: opacity 1.5: must be in [0,1]");
    expectComplaint("[" + good + R"({"value": 1, "opacity": -1}])", "point 2: opacity -1: must be in [0,1]");
    expectComplaint("[" + good + R"({"value": -1, "opacity": 1}])", "point 2: value -1 is below");
    expectComplaint("[" + good + R"({"value": 1, "opacity": 1, "alpha": 1}])", "point 2: \"alpha\" is not known");
    expectComplaint("[" + good + R"({"value": 1, "opacity": 1, "color": [1,1,1]}])", "point 2 has \"color\"");
    for (const char* color : {"[1,1]", "1", "[1,1,\"x\"]", "\"red\""})
        expectComplaint(R"([{"value": 1, "opacity": 1, "color": )" + std::string(color) + "}]",
                        "not a list of three numbers");
    expectComplaint(R"([{"value": 1, "opacity": 1, "color": [1,255,0]}])", "point 1: color 255");
}
