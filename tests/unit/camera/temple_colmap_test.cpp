// A model that COLMAP made of real photographs (Middlebury's temple): its cameras stand to each other as the ones that
// were measured do.
#include "raysweep/camera/object_bounds.h"
#include "raysweep/camera/poses.h"

#include "support/source_folder.h"
#include "support/volumes.h"
#include "support/worst.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <utility>
#include <vector>

using namespace raysweep;
namespace fs = std::filesystem;

namespace {

std::string nameOf(const Pose& pose) {
    return fs::path(pose.image).filename().string();
}

/// Angle between the views' rotations, rad.
double angleBetween(const PhotoCamera& a, const PhotoCamera& b) {
    const double trace = a.right.dot(b.right) + a.down.dot(b.down) + a.forward.dot(b.forward);
    return std::acos(std::clamp((trace - 1) / 2, -1.0, 1.0));
}

/// Cameras of one picture in both, in the order of names.
std::vector<std::pair<PhotoCamera, PhotoCamera>> common(const Poses& first, const Poses& second) {
    std::map<std::string, PhotoCamera> cameras;
    for (const Pose& pose : second.views) cameras[nameOf(pose)] = pose.camera;
    std::vector<std::pair<PhotoCamera, PhotoCamera>> pairs;
    for (const Pose& pose : first.views)
        if (cameras.count(nameOf(pose)) > 0) pairs.emplace_back(pose.camera, cameras[nameOf(pose)]);
    return pairs;
}

}  // namespace

TEST(TempleColmap, AgreesWithTheMeasuredCameras) {
    const std::string list = test::findData("photos/temple/templeSR_par.txt");
    if (list.empty()) GTEST_SKIP() << "the temple's photographs are not here";
    PoseOptions options;
    options.imageFolder = fs::path(list).parent_path().string();
    const Poses colmap = readPoses((fs::path(test::sourceFolder()) / "tests/data/temple_colmap").string(), options);
    const Poses measured = readPoses(list, options);
    ASSERT_EQ(colmap.views.size(), 13u);
    EXPECT_EQ(colmap.points.size(), 300u);
    EXPECT_EQ(measured.views.size(), 16u);
    const auto pairs = common(colmap, measured);
    ASSERT_EQ(pairs.size(), 13u);

    // Two of the views were taken from one place, as the turntable turned: such pairs have no ratio of distances.
    std::vector<std::pair<double, double>> distances;
    double worstAngle = 0;
    for (std::size_t a = 0; a < pairs.size(); ++a)
        for (std::size_t b = a + 1; b < pairs.size(); ++b) {
            const double known = (pairs[a].second.position - pairs[b].second.position).length();
            if (known > 0.1)
                distances.emplace_back((pairs[a].first.position - pairs[b].first.position).length(), known);
            test::raiseTo(worstAngle, std::abs(angleBetween(pairs[a].first, pairs[b].first) -
                                               angleBetween(pairs[a].second, pairs[b].second)));
        }
    double scale = 0, worstRatio = 0;
    for (const auto& [found, known] : distances) scale += found / known / double(distances.size());
    for (const auto& [found, known] : distances) test::raiseTo(worstRatio, std::abs(found / known / scale - 1));
    EXPECT_LE(worstRatio, 0.017);   // found: 0.0155
    EXPECT_LE(worstAngle, 0.0154);  // found: 0.0141; bundle adjustment of 13 views and a lens of its own
    for (const auto& [found, known] : pairs) EXPECT_NEAR(found.focalX / known.focalX, 1, 0.01);
}

TEST(TempleColmap, PointsSayWhereTheTempleIs) {
    const std::string list = test::findData("photos/temple/templeSR_par.txt");
    if (list.empty()) GTEST_SKIP() << "the temple's photographs are not here";
    PoseOptions options;
    options.imageFolder = fs::path(list).parent_path().string();
    const Poses colmap = readPoses((fs::path(test::sourceFolder()) / "tests/data/temple_colmap").string(), options);
    const Box3 box = estimatedBounds(colmap);
    for (const Pose& pose : colmap.views) {
        const auto seen = project(pose.camera, box.center());
        ASSERT_TRUE(seen) << pose.image;
        EXPECT_NEAR(seen->x, 320, 160) << pose.image;  // the temple stands in the middle half
        EXPECT_NEAR(seen->y, 240, 120) << pose.image;
    }
}
