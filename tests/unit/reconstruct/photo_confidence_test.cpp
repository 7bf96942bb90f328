#include "raysweep/reconstruct/photo_confidence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"

using namespace raysweep;
using openvdb::Coord;

namespace {

constexpr double kEdge = 0.5;    ///< of voxels, world units
constexpr int kVoxels = 16;      ///< along each axis
constexpr int kPerSlice = 2;     ///< samples of a ray
const openvdb::Vec3d kFirst(3);  ///< centre of voxel (0,0,0)

/// @param depth extinction times the edge of a voxel; voxels without are inactive
openvdb::FloatGrid::Ptr volumeOf(const std::function<double(const Coord&)>& depth) {
    const auto grid = openvdb::FloatGrid::create(0);
    const auto transform = openvdb::math::Transform::createLinearTransform(kEdge);
    transform->postTranslate(kFirst);
    grid->setTransform(transform);
    for (const Coord& at : openvdb::CoordBBox(Coord(0), Coord(kVoxels - 1)))
        if (depth(at) > 0) grid->tree().setValue(at, float(depth(at) / kEdge));
    return grid;
}

/// Along an axis, with a ray through the middle of each row of voxels.
Photograph photographAlong(int axis) {
    Photograph photograph{"along", {}, Image(kVoxels, kVoxels, 4)};
    PhotoCamera& camera = photograph.camera;
    camera.projection = Camera::Projection::Orthographic;
    const double middle = kFirst[0] + 0.5 * (kVoxels - 1) * kEdge;
    camera.position = Vec3(middle);
    camera.position[axis] = kFirst[0] - 10;
    camera.forward = camera.right = camera.down = Vec3(0);
    camera.forward[axis] = camera.right[(axis + 1) % 3] = camera.down[(axis + 2) % 3] = 1;
    camera.focalX = camera.focalY = 1 / kEdge;
    camera.principalX = camera.principalY = 0.5 * kVoxels;
    camera.width = camera.height = kVoxels;
    return photograph;
}

/// Eq. 1 along a row of voxels through whose middles a ray goes, in double.
std::vector<double> partsOf(const std::vector<double>& depths) {
    std::vector<double> parts(depths.size() + 2);  // with a voxel before and one behind
    double transmittance = 1;
    for (int k = 1; k < int(depths.size() + 1) * kPerSlice; ++k) {
        const int below = k / kPerSlice;  // counted from the voxel before
        const double part = double(k % kPerSlice) / kPerSlice;
        const auto depth = [&](int i) { return i < 1 || i > int(depths.size()) ? 0 : depths[std::size_t(i - 1)]; };
        const double behind =
            transmittance * std::exp(-((1 - part) * depth(below) + part * depth(below + 1)) / kPerSlice);
        parts[std::size_t(below)] += (1 - part) * (transmittance - behind);
        parts[std::size_t(below + 1)] += part * (transmittance - behind);
        transmittance = behind;
    }
    return {parts.begin() + 1, parts.end() - 1};
}

float valueAt(const openvdb::FloatGrid& grid, const Coord& at) {
    return grid.tree().getValue(at);
}

/// Around the middle of the volume, at a distance of 12 world units; the ball there covers a good part of the pictures.
std::vector<Vec3> positions(int count) {
    std::vector<Vec3> all;
    for (int n = 0; n < count; ++n) {
        const double z = 1 - (2 * n + 1.0) / count, r = std::sqrt(1 - z * z), angle = 2.399963 * n;
        all.push_back(Vec3(r * std::cos(angle), r * std::sin(angle), z) * 12.0);
    }
    return all;
}

}  // namespace

// A slab across the rays: layer after layer as the plain twin has it. Floats: samples' parts are differences of
// transmittances, rounded to 6e-8 each; parts of samples below 1e-4 are left out: there are 4.4e-5.
TEST(PhotoConfidence, SlabLayerByLayer) {
    for (const double depth : {0.3, 2.0})
        for (int axis = 0; axis < 3; ++axis) {
            const auto volume = volumeOf([&](const Coord& at) { return at[axis] >= 3 && at[axis] < 13 ? depth : 0; });
            const PhotoConfidence seen = photoConfidence(*volume, {photographAlong(axis)});
            const std::vector<double> expected = partsOf(std::vector<double>(10, depth));
            EXPECT_GT(expected[0], depth < 1 ? 0.2 : 0.6);
            for (int layer = 0; layer < 10; ++layer) {
                Coord at(5, 9, 7);
                at[axis] = 3 + layer;
                EXPECT_NEAR(valueAt(*seen.confidence, at), expected[std::size_t(layer)], 4.8e-5);
                EXPECT_EQ(valueAt(*seen.views, at), expected[std::size_t(layer)] >= 0.05 ? 1 : 0);
            }
            if (depth < 1) continue;
            Coord hidden(5, 9, 7);
            hidden[axis] = 9;
            EXPECT_EQ(valueAt(*seen.confidence, hidden), 0);  // e^-12 at the most
        }
}

// A voxel behind an opaque plate in one view is seen by the other alone, and as that one sees it: as if the plate was
// not there. The plate itself is seen face on and, its edge, from the side.
TEST(PhotoConfidence, BehindAPlate) {
    const auto volume = volumeOf([](const Coord& at) {
        const bool plate = at.x() == 3 || at.x() == 4, behind = at == Coord(8, 8, 8);
        return plate ? 20.0 : (behind ? 0.7 : 0);
    });
    const std::vector<Photograph> both = {photographAlong(0), photographAlong(1)};
    const PhotoConfidence seen = photoConfidence(*volume, both);
    EXPECT_EQ(valueAt(*seen.views, Coord(8, 8, 8)), 1);
    EXPECT_NEAR(valueAt(*seen.confidence, Coord(8, 8, 8)), partsOf({0.7})[0], 1e-5);
    EXPECT_EQ(valueAt(*seen.views, Coord(3, 8, 8)), 1);
    EXPECT_EQ(valueAt(*seen.views, Coord(3, 0, 8)), 2);
    const PhotoConfidence front = photoConfidence(*volume, {both[0]});
    EXPECT_EQ(valueAt(*front.views, Coord(8, 8, 8)), 0);
    EXPECT_EQ(valueAt(*front.confidence, Coord(8, 8, 8)), 0);
    EXPECT_EQ(front.views->activeVoxelCount(), volume->activeVoxelCount());
}

// An opaque ball, from all around: a piece of surface is seen from where it is above the horizon, cos > radius /
// distance; the inside from nowhere. Near the horizon either may be: voxels have edges.
TEST(PhotoConfidence, BallFromAllAround) {
    const Vec3 middle(kFirst[0] + 0.5 * (kVoxels - 1) * kEdge);
    const double radius = 3;
    const auto from = [&](const Coord& at) {
        const openvdb::Vec3d place = kFirst + at.asVec3d() * kEdge;
        return Vec3(place.x(), place.y(), place.z()) - middle;
    };
    const auto volume = volumeOf([&](const Coord& at) { return from(at).length() < radius ? 8.0 : 0; });
    std::vector<Photograph> photographs;
    for (const Vec3& place : positions(20)) {
        Camera camera;
        camera.eye = middle + place;
        camera.target = middle;
        camera.up = Vec3(0.1, 0.2, 1);
        camera.width = camera.height = 40;
        photographs.push_back({"ball", photoCamera(camera), Image(40, 40, 4)});
    }
    const PhotoConfidence seen = photoConfidence(*volume, photographs);
    int surface = 0, inside = 0;
    for (auto voxel = volume->cbeginValueOn(); voxel; ++voxel) {
        const Vec3 place = from(voxel.getCoord());
        const float confidence = valueAt(*seen.confidence, voxel.getCoord());
        const float views = valueAt(*seen.views, voxel.getCoord());
        ASSERT_GE(confidence, 0);
        ASSERT_LE(confidence, 1);
        if (place.length() < radius - 3 * kEdge) {
            ++inside;
            EXPECT_EQ(views, 0);
            EXPECT_LT(confidence,
                      2e-3);  // there are 5e-4: two voxels of e^-8 before it, a flank, and a slanting way in
        }
        if (place.length() < radius - 0.4 * kEdge) continue;
        ++surface;
        int sure = 0, possible = 0;
        for (const Photograph& photograph : photographs) {
            const double cosine = (photograph.camera.position - middle - place).normalized().dot(place.normalized());
            sure += cosine > 0.5;
            possible += cosine > -0.35;
        }
        EXPECT_GE(views, sure) << voxel.getCoord();
        EXPECT_LE(views, possible) << voxel.getCoord();
        EXPECT_GT(confidence, 0.29) << voxel.getCoord();
    }
    EXPECT_GT(surface, 100);
    EXPECT_GT(inside, 100);
}

TEST(PhotoConfidence, SameBitsForAnyThreads) {
    const auto volume = volumeOf([](const Coord& at) { return (at.x() * 7 + at.y() * 3 + at.z() * 5) % 4 * 0.1; });
    const std::vector<Photograph> photographs = {photographAlong(0), photographAlong(1), photographAlong(2)};
    std::vector<PhotoConfidence> all;
    for (const int threads : {1, 2, 5}) {
        const ThreadLimit limit(threads);
        all.push_back(photoConfidence(*volume, photographs));
    }
    for (const PhotoConfidence& one : all)
        for (auto voxel = volume->cbeginValueOn(); voxel; ++voxel) {
            EXPECT_EQ(valueAt(*one.confidence, voxel.getCoord()), valueAt(*all[0].confidence, voxel.getCoord()));
            EXPECT_EQ(valueAt(*one.views, voxel.getCoord()), valueAt(*all[0].views, voxel.getCoord()));
        }
}

TEST(PhotoConfidence, StopsAndRefuses) {
    const auto volume = volumeOf([](const Coord&) { return 1.0; });
    const std::vector<Photograph> photographs = {photographAlong(0)};
    EXPECT_EQ(photoConfidence(*volume, photographs, {}, [](const std::string&, double) { return false; }).views,
              nullptr);
    PhotoConfidenceOptions none;
    none.seen = 0;
    EXPECT_THROW(photoConfidence(*volume, photographs, none), InvalidArgument);
    EXPECT_THROW(photoConfidence(*volume, {}), InvalidArgument);
    const auto nothing = openvdb::FloatGrid::create(0);
    EXPECT_EQ(photoConfidence(*nothing, photographs).views->activeVoxelCount(), 0u);
    volume->transform().preScale(openvdb::Vec3d(1, 1, 2));
    EXPECT_THROW(photoConfidence(*volume, photographs), InvalidArgument);
}
