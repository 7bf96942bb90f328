// Diffuse surfaces against radiosity's exact answers: plates, boxes, view factors; voxel walls stand for the planes.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/illuminate/illuminate.h"
#include "support/volumes.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

using openvdb::Coord;
using openvdb::FloatGrid;

constexpr float kWall = 4.6f;  ///< optical depth of a full voxel: opacity 0.99

/// A grid with the positive values of `value` in the voxels of a box [0, size).
FloatGrid::Ptr gridOf(const Index3& size, const std::function<double(int, int, int)>& value) {
    auto grid = FloatGrid::create(0);
    auto accessor = grid->getAccessor();
    for (int x = 0; x < size.x; ++x)
        for (int y = 0; y < size.y; ++y)
            for (int z = 0; z < size.z; ++z)
                if (const double v = value(x, y, z); v > 0) accessor.setValue(Coord(x, y, z), float(v));
    return grid;
}

/// Mean of the radiosity over the voxels that `isPart` accepts.
double meanOver(const openvdb::GridBase& grid, const Index3& size, const std::function<bool(int, int, int)>& isPart) {
    const auto accessor = static_cast<const FloatGrid&>(grid).getConstAccessor();
    double sum = 0, count = 0;
    for (int x = 0; x < size.x; ++x)
        for (int y = 0; y < size.y; ++y)
            for (int z = 0; z < size.z; ++z)
                if (isPart(x, y, z)) {
                    sum += double(accessor.getValue(Coord(x, y, z)));
                    ++count;
                }
    return sum / count;
}

Scene wallScene(FloatGrid::Ptr density, double reflectance) {
    Scene scene;
    scene.medium.density = density;
    scene.medium.solid = true;
    scene.medium.albedo = grey(float(reflectance));
    return scene;
}

IlluminateOptions sweepsOf(int count, Exchange exchange = Exchange::automatic) {
    IlluminateOptions options;
    options.tolerance = 0;
    options.sweeps = count;
    options.exchange = exchange;
    return options;
}

/// Two infinite parallel plates, `axis` across, `gap` voxels apart; the lower one emits 1 W per area.
/// Exact: E_lower = 2/3, E_upper = 4/3 at reflectance 1/2.
struct Plates {
    double emitting, other;  ///< irradiances
    double balance;
};

Plates plates(int axis, Exchange exchange, int sweeps) {
    const int kWidth = 8, kThick = 3, kGap = 10, high = 2 * kThick + kGap;
    Index3 size(kWidth);
    size[axis] = high;
    const auto depth = [axis](int x, int y, int z) { return axis == 0 ? x : axis == 1 ? y : z; };
    Scene scene = wallScene(gridOf(size,
                                   [&](int x, int y, int z) {
                                       const int d = depth(x, y, z);
                                       return d < kThick || d >= kThick + kGap ? double(kWall) : 0.0;
                                   }),
                            0.5);
    scene.medium.emission = gridOf(size, [&](int x, int y, int z) { return depth(x, y, z) == kThick - 1 ? 1.0 : 0.0; });
    IlluminateOptions options = sweepsOf(sweeps, exchange);
    options.periodic = {true, true, true};
    options.periodic[std::size_t(axis)] = false;
    const Illumination lit = illuminate(scene, options);
    const auto irradiance = [&](int layer, double emitted) {
        const double S = meanOver(*lit.radiosity, size, [&](int x, int y, int z) { return depth(x, y, z) == layer; });
        return (S * kPi - emitted) / 0.5;
    };
    return {irradiance(kThick - 1, 1), irradiance(kThick + kGap, 0), lit.power.error()};
}

/// A point's height in a scene turned about the y axis through the middle of a cube of voxels.
struct Frame {
    int edge;
    double angle;

    Vec3 local(int x, int y, int z) const {
        const double middle = 0.5 * (edge - 1), c = std::cos(angle), s = std::sin(angle);
        const double dx = x - middle, dy = y - middle, dz = z - middle;
        return {c * dx + s * dz, dy, -s * dx + c * dz};
    }
    Vec3 turned(const Vec3& v) const {
        const double c = std::cos(angle), s = std::sin(angle);
        return {c * v.x - s * v.z, v.y, s * v.x + c * v.z};
    }
    Vec3 world(const Vec3& at) const { return turned(at) + Vec3(0.5 * (edge - 1)); }
};

/// How a solid becomes voxels.
enum class Edges { sharp, partial };

/// Optical depth of the voxels of a solid that is where `distance` (voxels, negative inside) is negative.
FloatGrid::Ptr solidGrid(const Frame& frame, Edges edges, const std::function<double(const Vec3&)>& distance) {
    return gridOf(Index3(frame.edge), [&](int x, int y, int z) {
        const double d = distance(frame.local(x, y, z));
        const double filled = edges == Edges::sharp ? double(d < 0) : std::min(1.0, std::max(0.0, 0.5 - d));
        return filled > 0 ? -std::log1p(-0.99 * filled) : 0.0;
    });
}

/// Mean of the radiosity over the voxels of a part of the solid, weighted by opacity as an eye would.
double radiosityOver(const openvdb::GridBase& grid, const FloatGrid& density, const Frame& frame,
                     const std::function<bool(const Vec3&)>& isPart) {
    const auto radiosity = static_cast<const FloatGrid&>(grid).getConstAccessor();
    double sum = 0, weights = 0;
    for (auto on = density.cbeginValueOn(); on; ++on) {
        const Coord at = on.getCoord();
        if (!isPart(frame.local(at.x(), at.y(), at.z()))) continue;
        const double weight = -std::expm1(-double(*on));
        sum += weight * double(radiosity.getValue(at));
        weights += weight;
    }
    return sum / weights;
}

/// Flux that a parallelogram of unit radiosity sends through another one, per area of that: Lambert's double integral
/// by midpoints.
double irradianceThrough(const QuadLight& from, const QuadLight& to) {
    const int kPoints = 64;
    const Vec3 n = from.u.cross(from.v).normalized(), m = to.u.cross(to.v).normalized();
    const double area = from.u.cross(from.v).length() / (kPoints * kPoints);
    double sum = 0;
    for (int i = 0; i < kPoints * kPoints; ++i) {
        const Vec3 a =
            from.corner + from.u * ((i / kPoints + 0.5) / kPoints) + from.v * ((i % kPoints + 0.5) / kPoints);
        for (int j = 0; j < kPoints * kPoints; ++j) {
            const Vec3 way =
                to.corner + to.u * ((j / kPoints + 0.5) / kPoints) + to.v * ((j % kPoints + 0.5) / kPoints) - a;
            const double squared = way.dot(way);
            sum += std::max(0.0, n.dot(way)) * std::max(0.0, -m.dot(way)) / (kPi * squared * squared);
        }
    }
    return sum * area / (kPoints * kPoints);
}

/// A quad of flux 1 per area shines at a part of a solid. The quad floats a little above any solid, so that it shares
/// no voxel with it.
struct Patch {
    QuadLight light, target;                      ///< in the frame's coordinates
    std::function<double(const Vec3&)> distance;  ///< of the solid
    std::function<double(const Vec3&)> depth;     ///< of a point below the target's plane
};
constexpr double kLift = 2;
constexpr double kMiddle = 0.5;  ///< where, between whole numbers, voxels have their middle: a quad is as thick as one

bool isOver(const QuadLight& quad, const Vec3& p) {
    const Vec3 at = p - quad.corner;
    const double u = at.dot(quad.u) / quad.u.dot(quad.u), v = at.dot(quad.v) / quad.v.dot(quad.v);
    return u > 0 && u < 1 && v > 0 && v < 1;
}

/// @return mean irradiance of the target, in parts of the exact one
double lightPatch(const Patch& patch, const Frame& frame, Edges edges, IlluminateOptions options) {
    const double reflectance = 0.02;
    const auto density = solidGrid(frame, edges, patch.distance);
    Scene scene = wallScene(density, reflectance);
    scene.quads.push_back({frame.world(patch.light.corner), frame.turned(patch.light.u), frame.turned(patch.light.v),
                           grey(float(1 / kPi))});
    const Illumination lit = illuminate(scene, options);
    const double S = radiosityOver(*lit.radiosity, *density, frame, [&](const Vec3& p) {
        return isOver(patch.target, p) && patch.depth(p) > -0.5 && patch.depth(p) < 0.75;
    });
    return S * kPi / reflectance / irradianceThrough(patch.light, patch.target);
}

/// Unit squares that face each other at a distance of their side (less `lift`): 0.19982.
/// @param lift brings the light nearer
Patch facingSquares(double side, double lift) {
    const double h = 0.5 * side;
    Patch patch;
    patch.light = {{-h, -h, lift - h}, {side, 0, 0}, {0, side, 0}};
    patch.target = {{-h, -h, h}, {0, side, 0}, {side, 0, 0}};
    patch.depth = [h](const Vec3& p) { return p.z - h; };
    patch.distance = [=](const Vec3& p) {
        const double across = std::max(std::abs(p.x), std::abs(p.y)) - 0.75 * side;
        return std::max({h - p.z, p.z - h - 4, across});
    };
    return patch;
}

/// Unit squares at a right angle that (nearly) share an edge: about 0.2.
Patch cornerSquares(double side) {
    const double h = 0.5 * side;
    Patch patch;
    patch.light = {{-h, -h, kMiddle - h}, {side, 0, 0}, {0, side, 0}};
    patch.target = {{-h - kLift, -h, kMiddle - h}, {0, side, 0}, {0, 0, side}};
    patch.depth = [h](const Vec3& p) { return -h - kLift - p.x; };
    patch.distance = [=](const Vec3& p) {
        const double across = std::max(std::abs(p.y), std::abs(p.z)) - 0.75 * side;
        return std::max({p.x + h + kLift, -h - kLift - 4 - p.x, across});
    };
    return patch;
}

/// A closed box of reflectance 1/2 with a light of flux 1 per area before each inner face: irradiance 2 on every face.
/// @return mean irradiance of each face, in parts of that
std::vector<double> closedBox(const Frame& frame, Edges edges, double side, IlluminateOptions options) {
    const double h = 0.5 * side, inner = h - kLift;
    const auto density = solidGrid(frame, edges, [&](const Vec3& p) {
        const double most = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
        return std::max(h - most, most - h - 4);
    });
    Scene scene = wallScene(density, 0.5);
    const auto faces = [&](const auto& visit) {
        for (int axis = 0; axis < 3; ++axis)
            for (const double sign : {-1.0, 1.0}) visit(axis, sign);
    };
    faces([&](int axis, double sign) {
        const double reach = inner - kLift;  // lights that touched would share voxels
        Vec3 corner(-reach), u(0), v(0);
        corner[axis] = sign * inner;
        u[(axis + 1) % 3] = 2 * reach;
        v[(axis + 2) % 3] = 2 * reach;
        if (sign > 0) std::swap(u, v);
        const double radiance = (h * h) / (reach * reach) / kPi;
        scene.quads.push_back({frame.world(corner), frame.turned(u), frame.turned(v), grey(float(radiance))});
    });
    const Illumination lit = illuminate(scene, options);
    std::vector<double> irradiances;
    faces([&](int axis, double sign) {
        const double S = radiosityOver(*lit.radiosity, *density, frame, [&](const Vec3& p) {
            const double depth = sign * p[axis] - h;
            return depth > -0.5 && depth < 0.75 && std::abs(p[(axis + 1) % 3]) < h && std::abs(p[(axis + 2) % 3]) < h;
        });
        irradiances.push_back(S * kPi / 0.5 / 2);
    });
    return irradiances;
}

/// What is promised for walls along the axes and for tilted ones, where staircases do something to light from one side.
/// Measured over several seeds (docs/validation.md): at most 2 % and 6 %.
double toleranceOf(const Frame& frame) {
    return frame.angle == 0 ? 0.03 : 0.065;
}

/// Few of all directions lead from one patch to another: noise is 1 % at 4096 sweeps.
int sweepsFor(const Frame& frame) {
    return frame.angle == 0 ? 32768 : 8192;
}

constexpr double kBright = 0.9;

const Frame kStraight{72, 0};
const Frame kTilted{72, kPi / 6};

}  // namespace

TEST(Surface, ParallelPlatesExchangeTheExactPower) {
    for (int axis = 0; axis < 3; ++axis) {
        const Plates found = plates(axis, Exchange::automatic, 4096);
        EXPECT_LE(std::abs(found.emitting / (2.0 / 3) - 1), 0.03) << "axis " << axis;
        EXPECT_LE(std::abs(found.other / (4.0 / 3) - 1), 0.03) << "axis " << axis;
        EXPECT_LE(found.balance, 1e-5);  // the promise of float storage
    }
}

TEST(Surface, PaperModelLeaksThroughPlatesAsTheDesignSays) {
    const Plates found = plates(2, Exchange::paper, 1024);
    EXPECT_LE(found.balance, 1e-5);
    // Not a property to keep but the reason for the other rule: the cosine lets a good part of the power through.
    EXPECT_LT(found.other, 0.95 * 4 / 3);
    EXPECT_GT(found.other, 0.8);
}

TEST(SurfaceSlow, FacingSquaresReceiveTheExactIrradiance) {
    EXPECT_LE(std::abs(irradianceThrough(facingSquares(1, 0).light, facingSquares(1, 0).target) - 0.19982), 5e-5);
    for (const Frame& frame : {kStraight, kTilted})
        for (const Edges edges : {Edges::sharp, Edges::partial})
            EXPECT_LE(std::abs(lightPatch(facingSquares(32, kMiddle), frame, edges, sweepsOf(sweepsFor(frame))) - 1),
                      toleranceOf(frame))
                << "tilt " << frame.angle << " edges " << int(edges);
}

TEST(SurfaceSlow, SquaresAtARightAngleReceiveTheExactIrradiance) {
    for (const Frame& frame : {kStraight, kTilted})
        for (const Edges edges : {Edges::sharp, Edges::partial})
            EXPECT_LE(std::abs(lightPatch(cornerSquares(32), frame, edges, sweepsOf(sweepsFor(frame))) - 1),
                      toleranceOf(frame))
                << "tilt " << frame.angle << " edges " << int(edges);
}

TEST(SurfaceSlow, ClosedBoxHasTheExactIrradianceOnEveryFace) {
    for (const Frame& frame : {kStraight, kTilted})
        for (const Edges edges : {Edges::sharp, Edges::partial})
            for (const double irradiance : closedBox(frame, edges, 32, sweepsOf(sweepsFor(frame) / 2)))
                EXPECT_LE(std::abs(irradiance - 1), toleranceOf(frame))
                    << "tilt " << frame.angle << " edges " << int(edges);
}

TEST(Surface, FurnaceLeavesAFlatWallAtOne) {
    for (int axis = 0; axis < 3; ++axis)
        for (const Interpolation interpolation : {Interpolation::nearest, Interpolation::linear}) {
            Index3 size(24);
            size[axis] = 4;
            // Not so bright that the white furnace takes the place of the local one; nothing here is lit twice.
            Scene scene = wallScene(gridOf(size, [](int, int, int) { return double(kWall); }), kBright);
            scene.sky.radiance = grey(float(1 / kBright));
            IlluminateOptions options = sweepsOf(128);
            options.interpolation = interpolation;
            const Illumination lit = illuminate(scene, options);
            const double S = meanOver(*lit.radiosity, size, [&](int x, int y, int z) {
                const int at[3] = {x, y, z};
                bool inner = at[axis] == 0;
                for (int other = 0; other < 3; ++other)
                    inner = inner && (other == axis || (at[other] > 3 && at[other] < 20));
                return inner;
            });
            EXPECT_LE(std::abs(S - 1), 0.03) << "axis " << axis << " interpolation " << int(interpolation);
        }
}

TEST(Surface, FurnaceStaysCloseToOneOnASphere) {
    for (const Edges edges : {Edges::sharp, Edges::partial}) {
        const Frame frame{40, 0};
        const double radius = 16;
        const auto density = solidGrid(frame, edges, [&](const Vec3& p) { return p.length() - radius; });
        Scene scene = wallScene(density, kBright);
        scene.sky.radiance = grey(float(1 / kBright));
        const Illumination lit = illuminate(scene, sweepsOf(512));
        double squares = 0, count = 0;
        for (auto on = density->cbeginValueOn(); on; ++on) {
            const Coord at = on.getCoord();
            if (frame.local(at.x(), at.y(), at.z()).length() < radius - 1) continue;
            const double S = double(static_cast<const FloatGrid&>(*lit.radiosity).tree().getValue(at));
            squares += (S - 1) * (S - 1);
            ++count;
        }
        // Measured 0.5 % and 0.1 %; the local furnace cannot know a staircase from what it stands for.
        EXPECT_LE(std::sqrt(squares / count), edges == Edges::sharp ? 0.012 : 0.004);
    }
}

namespace {

/// The inside of a cup, [0, kCup) by [0, kCup) by [0, kDeep) voxels, open at the top.
constexpr int kCup = 14, kDeep = 17, kCupWall = 3;

/// Radiosity of places spread over its floor, diffuse and of `reflectance`, in a sky of 1: paths of light backwards.
double floorOfCup(double reflectance, int paths) {
    std::mt19937_64 random(3);
    const auto even = [&] { return std::uniform_real_distribution<double>()(random); };
    const Vec3 size(kCup, kCup, kDeep);
    double sum = 0;
    for (int n = 0; n < paths; ++n) {
        Vec3 at(kCup * even(), kCup * even(), 0);
        int axis = 2;
        double sign = 1, weight = reflectance;  // the wall's normal
        for (;;) {
            const double r = std::sqrt(even()), around = 2 * kPi * even();
            Vec3 way;
            way[axis] = sign * std::sqrt(1 - r * r);
            way[(axis + 1) % 3] = r * std::cos(around);
            way[(axis + 2) % 3] = r * std::sin(around);
            double nearest = INFINITY;
            for (int a = 0; a < 3; ++a) {
                const double distance = ((way[a] > 0 ? size[a] : 0) - at[a]) / way[a];
                if (distance < nearest && (a != axis || way[a] * sign > 0) && way[a] != 0) nearest = distance, axis = a;
            }
            if (axis == 2 && way.z > 0) break;
            at += way * nearest;
            sign = way[axis] > 0 ? -1 : 1;
            weight *= reflectance;
        }
        sum += weight;
    }
    return sum / paths;
}

}  // namespace

// Light is scattered often in it, and what is wrong along its edges adds up: steep rays go up through the rim's voxels
// against whose normals they come, and the floor is too dark. Beyond an albedo of 0.9 the white furnace, which lacks
// the same light, makes up for most of that; without it 0.95 and 0.99 were .146 and .176 off.
TEST(Surface, ACupIsAsBrightAsPathsOfLightSay) {
    const Index3 size(kCup + 2 * kCupWall, kCup + 2 * kCupWall, kDeep + kCupWall);
    // Found .059, .112, .047, .009; a tenth more.
    const std::pair<double, double> kFound[] = {{0.8, 0.065}, {0.9, 0.123}, {0.95, 0.051}, {0.99, 0.0095}};
    const auto isInside = [](int x) { return x >= kCupWall && x < kCupWall + kCup; };
    for (const auto& [reflectance, limit] : kFound) {
        Scene scene = wallScene(
            gridOf(size, [&](int x, int y,
                             int z) { return isInside(x) && isInside(y) && z >= kCupWall ? 0.0 : double(kWall); }),
            reflectance);
        scene.sky.radiance = grey(1);
        const Illumination lit = illuminate(scene, sweepsOf(1024));
        const double found = meanOver(
            *lit.radiosity, size, [&](int x, int y, int z) { return isInside(x) && isInside(y) && z == kCupWall - 1; });
        const double exact = floorOfCup(reflectance, 400000);
        std::printf("  reflectance %.2f: %.4f, paths %.4f, %+.4f; white %.2f\n", reflectance, found, exact,
                    found / exact - 1, lit.whiteFurnaceShare);
        EXPECT_LE(std::abs(found / exact - 1), limit) << reflectance;
    }
}

TEST(Surface, SunAndPointShowLambertsLawAndShadows) {
    for (const double degrees : {0.0, 30.0}) {
        const Frame frame{48, degrees * kPi / 180};
        // A floor, and a small plate above its left half.
        const auto density = solidGrid(frame, Edges::partial, [](const Vec3& p) {
            const double floor = std::max({p.z + 10, -p.z - 14, std::max(std::abs(p.x), std::abs(p.y)) - 20});
            const double plate = std::max({std::abs(p.z - 8) - 2, std::abs(p.x + 10) - 5, std::abs(p.y) - 6});
            return std::min(floor, plate);
        });
        const auto floorAround = [&](const Illumination& lit, const Vec3& at) {
            return radiosityOver(*lit.radiosity, *density, frame, [&](const Vec3& p) {
                return std::abs(p.z + 10) < 0.75 && (Vec3(p.x, p.y, 0) - at).length() < 3;
            });
        };
        Scene scene = wallScene(density, 0.6);
        const Vec3 direction = Vec3(0.0, 0.5, -1).normalized();
        scene.suns.push_back({frame.turned(direction), grey(2)});
        Illumination lit = illuminate(scene, sweepsOf(0));
        EXPECT_LE(std::abs(floorAround(lit, {10, 0, 0}) / (0.6 * 2 * -direction.z / kPi) - 1), 0.03) << degrees;
        EXPECT_LE(floorAround(lit, {-10, 9, 0}), 0.02) << degrees;  // under the plate, where the sun throws its shadow
        scene.suns.clear();
        scene.points.push_back({frame.world({-10, 0, 20}), grey(100)});
        lit = illuminate(scene, sweepsOf(0));
        // 30 and half a voxel below, 23 aside; where the floor is tilted voxels' middles are up to 0.75 deep, 3 % of
        // light.
        const double exact = 0.6 / kPi * 100 / (4 * kPi) * 30.5 / std::pow(30.5 * 30.5 + 23 * 23, 1.5);
        EXPECT_LE(std::abs(floorAround(lit, {13, 0, 0}) / exact - 1), 0.04) << degrees;
        EXPECT_LE(floorAround(lit, {-10, 0, 0}), 0.02 * exact) << degrees;
    }
}

// Scans have slices farther apart than pixels, up to ten times.
TEST(Surface, AFloorOfFlatOrTallVoxelsIsLitLikeAnyOther) {
    for (const double height : {0.2, 1.0, 3.0, 5.0, 10.0}) {
        const auto density = gridOf({24, 24, 8}, [](int, int, int) { return 1.0; });
        const auto transform = openvdb::math::Transform::createLinearTransform(1.0);
        transform->preScale(openvdb::Vec3d(1, 1, height));
        density->setTransform(transform);
        Scene scene = wallScene(density, 0.5);
        scene.medium.extinctionScale = 4.6 / std::cbrt(height);
        const Vec3 direction = Vec3(0.3, 0.2, -1).normalized();
        scene.suns.push_back({direction, grey(3)});
        const Illumination lit = illuminate(scene, sweepsOf(0));
        const float found = static_cast<const FloatGrid&>(*lit.radiosity).tree().getValue({12, 12, 7});
        EXPECT_LE(std::abs(double(found) / (0.5 * 3 * -direction.z / kPi) - 1), 0.005) << height;
    }
}

// Where normals are wrong by a few degrees a sphere has rings.
TEST(Surface, SunOnASphereShowsLambertsLawWithoutRings) {
    const Frame frame{64, 0};
    const double radius = 27;
    const auto density = solidGrid(frame, Edges::partial, [&](const Vec3& p) { return p.length() - radius; });
    Scene scene = wallScene(density, 0.9);
    const Vec3 direction = Vec3(0.5, 0.6, -0.7).normalized();
    scene.suns.push_back({direction, grey(3)});
    const Illumination lit = illuminate(scene, sweepsOf(0));
    const auto radiosity = static_cast<const FloatGrid&>(*lit.radiosity).getConstAccessor();
    double squares = 0, weights = 0;
    for (auto on = density->cbeginValueOn(); on; ++on) {
        const Vec3 at = frame.local(on.getCoord().x(), on.getCoord().y(), on.getCoord().z());
        const double cosine = -at.normalized().dot(direction);
        if (at.length() < radius - 0.5 || cosine < 0.3) continue;
        const double weight = -std::expm1(-double(*on));
        const double error = double(radiosity.getValue(on.getCoord())) / (0.9 * 3 * cosine / kPi) - 1;
        squares += weight * error * error;
        weights += weight;
    }
    std::printf("  RMS %.4f\n", std::sqrt(squares / weights));
    EXPECT_LE(std::sqrt(squares / weights), 0.0085);  // 0.030 with normals of opacity that is not averaged
}

TEST(Surface, PowerAddsUpAndThreadsDoNotMatter) {
    const Frame frame{40, 0.3};
    const auto density = solidGrid(frame, Edges::partial, [](const Vec3& p) { return std::abs(p.length() - 12) - 3; });
    Scene scene = wallScene(density, 0.8);
    scene.sky.radiance = grey(0.5f);
    scene.suns.push_back({{0.3, -1, 0.2}, Color(1, 0.5f, 0.2f)});
    scene.points.push_back({{20, 20, 20}, grey(300)});
    scene.quads.push_back({{10, 10, 36}, {0, 20, 0}, {20, 0, 0}, grey(2)});
    for (const Interpolation interpolation : {Interpolation::nearest, Interpolation::linear})
        for (const Exchange exchange : {Exchange::surface, Exchange::paper}) {
            IlluminateOptions options = sweepsOf(40, exchange);
            options.interpolation = interpolation;
            const Illumination many = illuminate(scene, options);
            EXPECT_LE(many.power.error(), 1e-5);
            const ThreadLimit one(1);
            EXPECT_TRUE(sameBits(*many.radiosity, *illuminate(scene, options).radiosity));
        }
}

TEST(Surface, QuadShinesToOneSideWithItsWholePower) {
    // Nothing but two thin absorbers on both sides: what the quad sends is what the front one takes or what escapes.
    Scene scene = wallScene(gridOf(Index3(16), [](int, int, int z) { return z == 0 || z == 15 ? 1e-3 : 0.0; }), 0.5);
    scene.quads.push_back({{4, 4, 8}, {6, 0, 0}, {0, 5, 0}, grey(3)});
    const Illumination lit = illuminate(scene, sweepsOf(64, Exchange::medium));
    EXPECT_LE(std::abs(lit.power.injected[0] / (kPi * 3 * 30) - 1), 1e-5);
    EXPECT_GT(meanOver(*lit.radiosity, Index3(16), [](int, int, int z) { return z == 15; }),
              1000 * meanOver(*lit.radiosity, Index3(16), [](int, int, int z) { return z == 0; }));
}

TEST(Surface, AQuadLeavesFogAroundItAMedium) {
    // A quad that is dark, in fog so dense that it would count as solid if there were solids: the furnace stays white.
    Scene scene;
    scene.medium.density = gridOf(Index3(16), [](int, int, int) { return 1.0; });
    scene.medium.albedo = grey(1);
    scene.sky.radiance = grey(1);
    scene.quads.push_back({{4, 4, 8}, {6, 0, 0}, {0, 6, 0}, grey(0)});
    const Illumination lit = illuminate(scene, sweepsOf(256));
    const Departure departure = fromOne(*lit.radiosity, *scene.medium.density);
    // The layer of the quad scatters to one side, and takes less from the other: it is off, and darkens its
    // surroundings.
    EXPECT_LE(std::abs(departure.mean - 1), 0.03);
    EXPECT_LE(departure.rms, 0.1);
}

TEST(Surface, EmissionShowsWithoutSweeps) {
    Scene scene = wallScene(gridOf(Index3(16, 16, 4), [](int, int, int) { return double(kWall); }), 0);
    scene.medium.emission = gridOf(Index3(16, 16, 4), [](int, int, int z) { return z == 3 ? 2.0 : 0.0; });
    const Illumination lit = illuminate(scene, sweepsOf(0));
    const double S = meanOver(*lit.radiosity, Index3(16, 16, 4), [](int x, int y, int z) {
        return z == 3 && std::min({x, y, 15 - x, 15 - y}) > 3;
    });
    EXPECT_LE(std::abs(S / (2 / kPi) - 1), 1e-5);
}

TEST(Surface, RefusesQuadsWithoutArea) {
    Scene scene = wallScene(gridOf(Index3(2), [](int, int, int) { return 1.0; }), 0.5);
    scene.quads.push_back({{0, 0, 0}, {1, 1, 0}, {2, 2, 0}, grey(1)});
    EXPECT_THROW(illuminate(scene), InvalidArgument);
}
