#include "raysweep/camera/object_bounds.h"

#include "raysweep/core/error.h"
#include "raysweep/core/finite.h"
#include "raysweep/core/parallel.h"
#include "raysweep/core/require.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>

namespace raysweep {
namespace {

constexpr double kFarthest = std::numeric_limits<double>::infinity();

/// Cubic cells that fill a box; those at its ends may reach beyond it.
struct Cells {
    Vec3 origin;
    double edge;
    Index3 size;

    explicit Cells(const Box3& box) : origin(box.min) {
        constexpr int kAlongLongest = 64;
        const Vec3 extent = box.size();
        edge = std::max({extent.x, extent.y, extent.z}) / kAlongLongest;
        for (int axis = 0; axis < 3; ++axis) size[axis] = std::max(1, int(std::ceil(extent[axis] / edge - 1e-9)));
    }
    Vec3 corner(const Index3& cell) const { return origin + Vec3(cell) * edge; }
};

Box3 intersection(const Box3& a, const Box3& b) {
    Box3 box;
    for (int axis = 0; axis < 3; ++axis) {
        box.min[axis] = std::max(a.min[axis], b.min[axis]);
        box.max[axis] = std::min(a.max[axis], b.max[axis]);
    }
    return box;
}

/// A box of cells, the last one included.
struct CellRange {
    Index3 first, last;

    bool isEmpty() const { return last.x < first.x || last.y < first.y || last.z < first.z; }
    int length(int axis) const { return last[axis] - first[axis] + 1; }
};

/// Whether any cell of the range is kept, where its number along `axis` is `at`.
template <class IsKept>
bool anyInPlane(const CellRange& range, int axis, int at, const IsKept& isKept) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    std::atomic<bool> any{false};
    parallelFor(std::size_t(range.length(v)), [&](std::size_t row) {
        Index3 cell;
        cell[axis] = at;
        cell[v] = range.first[v] + int(row);
        for (int n = 0; n < range.length(u) && !any; ++n) {
            cell[u] = range.first[u] + n;
            if (isKept(cell)) any = true;
        }
    });
    return any;
}

/// The box of the cells that are kept, and one more around them, within `box`, whose cells they are; empty if none is.
/// Planes of cells are taken away from each side until one has a cell to keep: those inside are not looked at.
/// @param isKept function of a cell's coordinates, called by several threads
template <class IsKept>
Box3 boxOfKept(const Box3& box, const Cells& cells, const IsKept& isKept) {
    CellRange range{Index3(0), cells.size - Index3(1)};
    for (int axis = 0; axis < 3; ++axis) {
        while (!range.isEmpty() && !anyInPlane(range, axis, range.first[axis], isKept)) ++range.first[axis];
        while (!range.isEmpty() && !anyInPlane(range, axis, range.last[axis], isKept)) --range.last[axis];
    }
    if (range.isEmpty()) return Box3();
    return intersection(Box3(cells.corner(range.first - Index3(1)), cells.corner(range.last + Index3(2))), box);
}

/// Repeats `shrink`, box to box, while it pays: cells get smaller with the box.
template <class Shrink>
Box3 shrunkWhileItPays(Box3 box, const Shrink& shrink) {
    constexpr int kMostRounds = 6;
    constexpr double kPays = 0.8;  ///< of the longest edge
    const auto longest = [](const Box3& b) { return std::max({b.size().x, b.size().y, b.size().z}); };
    for (int round = 0; round < kMostRounds; ++round) {
        const Box3 next = shrink(box);
        const bool pays = !next.isEmpty() && longest(next) < kPays * longest(box);
        box = next;
        if (!pays) break;
    }
    return box;
}

bool sees(const PhotoCamera& camera, const Vec3& point) {
    const auto seen = project(camera, point);
    return seen && seen->x >= 0 && seen->x <= camera.width && seen->y >= 0 && seen->y <= camera.height;
}

/// The radius of the largest ball about `middle` that the view sees whole, but for distortion; negative if it does not
/// see `middle`.
double radiusSeen(const PhotoCamera& camera, const Vec3& middle) {
    const Vec3 arm = middle - camera.position;
    const double x = arm.dot(camera.right), y = arm.dot(camera.down), depth = arm.dot(camera.forward);
    const bool perspective = camera.projection == Camera::Projection::Perspective;
    // Distance from the side that lies `pixels` from the principal point, on the side of positive `along`.
    const auto toSide = [&](double along, double focal, double pixels) {
        return perspective ? (pixels * depth - focal * along) / std::hypot(focal, pixels) : pixels / focal - along;
    };
    return std::min({toSide(x, camera.focalX, camera.width - camera.principalX),
                     toSide(-x, camera.focalX, camera.principalX),
                     toSide(y, camera.focalY, camera.height - camera.principalY),
                     toSide(-y, camera.focalY, camera.principalY), depth});
}

/// Values below it along one axis: the part `share` of them.
double quantile(std::vector<double>& values, double share) {
    const auto nth = values.begin() + std::ptrdiff_t(share * double(values.size() - 1) + 0.5);
    std::nth_element(values.begin(), nth, values.end());
    return *nth;
}

std::vector<Vec3> pointsSeenByHalf(const Poses& poses) {
    std::vector<std::uint8_t> isSeen(poses.points.size());
    parallelFor(
        poses.points.size(),
        [&](std::size_t n) {
            std::size_t count = 0;
            for (const Pose& pose : poses.views) count += sees(pose.camera, poses.points[n]);
            isSeen[n] = 2 * count >= poses.views.size();
        },
        1024);
    std::vector<Vec3> seen;
    for (std::size_t n = 0; n < isSeen.size(); ++n)
        if (isSeen[n]) seen.push_back(poses.points[n]);
    return seen;
}

/// How many pixels of a matte, from its top left corner to each pixel, the object covers.
struct CoverTable {
    int width;
    std::vector<std::uint32_t> counts;  ///< of (width + 1) × (height + 1), the first row and column 0

    explicit CoverTable(const Image& matte) : width(matte.width) {
        constexpr float kCovered = 1.0f / 32;  ///< alpha above which a pixel is more than noise of the matte
        const std::size_t stride = std::size_t(width) + 1;
        counts.resize(stride * (std::size_t(matte.height) + 1));
        for (int y = 0; y < matte.height; ++y) {
            std::uint32_t inRow = 0;
            for (int x = 0; x < width; ++x) {
                inRow += matte.at(x, y)[3] > kCovered;
                counts[(std::size_t(y) + 1) * stride + std::size_t(x) + 1] =
                    counts[std::size_t(y) * stride + std::size_t(x) + 1] + inRow;
            }
        }
    }
    std::uint32_t at(int x, int y) const { return counts[std::size_t(y) * (std::size_t(width) + 1) + std::size_t(x)]; }
    /// Whether any pixel in columns [x0, x1), rows [y0, y1) is covered.
    bool anyIn(int x0, int y0, int x1, int y1) const { return at(x1, y1) + at(x0, y0) != at(x0, y1) + at(x1, y0); }
};

/// What a matte says about places in the world.
struct Silhouette {
    const PhotoCamera& camera;
    CoverTable cover;
    bool isWhole;  ///< the picture cuts nothing off: what lies beside it is empty

    explicit Silhouette(const Photograph& photograph)
        : camera(photograph.camera), cover(photograph.matte), isWhole(!reachesEdge(photograph.matte)) {
        if (cover.at(camera.width, camera.height) == 0)
            throw InvalidArgument("the photograph '" + photograph.name +
                                  "' shows nothing: its matte is empty; leave it out, or change how it is matted");
    }

    static bool reachesEdge(const Image& matte) {
        constexpr float kSurely = 0.5f;  ///< alpha
        for (int y = 0; y < matte.height; ++y)
            for (int x = 0; x < matte.width; x += y == 0 || y == matte.height - 1 ? 1 : std::max(1, matte.width - 1))
                if (matte.at(x, y)[3] > kSurely) return true;
        return false;
    }
};

enum class Said { nothing, empty, covered };

/// What a view says about a cell: the pixels are those of the rectangle around its projected corners.
Said saidOf(const Silhouette& silhouette, const Vec3& corner, double edge) {
    const PhotoCamera& camera = silhouette.camera;
    double x0 = kFarthest, y0 = kFarthest, x1 = -kFarthest, y1 = -kFarthest;
    int projected = 0;
    for (int n = 0; n < 8; ++n) {
        const auto seen = project(camera, corner + Vec3(n & 1, n >> 1 & 1, n >> 2) * edge);
        if (!seen) continue;
        ++projected;
        x0 = std::min(x0, seen->x), y0 = std::min(y0, seen->y);
        x1 = std::max(x1, seen->x), y1 = std::max(y1, seen->y);
    }
    const Said beside = silhouette.isWhole ? Said::empty : Said::nothing;
    if (projected < 8) return projected == 0 ? beside : Said::nothing;
    if (x1 < 0 || y1 < 0 || x0 >= camera.width || y0 >= camera.height) return beside;
    const auto within = [](double at, int size) { return int(std::clamp(at, 0.0, double(size - 1))); };
    if (silhouette.cover.anyIn(within(x0, camera.width), within(y0, camera.height), within(x1, camera.width) + 1,
                               within(y1, camera.height) + 1))
        return Said::covered;
    const bool isInside = x0 >= 0 && y0 >= 0 && x1 <= camera.width && y1 <= camera.height;
    return isInside ? Said::empty : beside;
}

/// A cell is kept if no photograph says that it is empty, and enough of them that it is covered.
bool isCovered(const std::vector<Silhouette>& silhouettes, const Vec3& corner, double edge) {
    std::size_t covered = 0;
    for (const Silhouette& silhouette : silhouettes) {
        const Said said = saidOf(silhouette, corner, edge);
        if (said == Said::empty) return false;
        covered += said == Said::covered;
    }
    return 4 * covered >= silhouettes.size();
}

void requirePhotograph(const Photograph& photograph) {
    const std::string name = "the photograph '" + photograph.name + "'";
    const Image& matte = photograph.matte;
    if (matte.channels != 4 || matte.width != photograph.camera.width || matte.height != photograph.camera.height)
        throw InvalidArgument(name + ": its matte must be RGBA of its camera's size");
}

/// The point with the least weighted sum of squared distances to lines; none if they are nearly parallel.
std::optional<Vec3> nearestPoint(const std::vector<Ray>& lines, const std::vector<double>& weights) {
    Matrix3 normal(0.0);
    Vec3 right(0);
    double sum = 0;
    for (std::size_t n = 0; n < lines.size(); ++n) {
        const Vec3& d = lines[n].direction;
        right += (lines[n].origin - d * d.dot(lines[n].origin)) * weights[n];
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) normal[i][j] += weights[n] * ((i == j) - d[i] * d[j]);
        sum += weights[n];
    }
    // Two lines at an angle a have a determinant of sin²(a) / 4.
    constexpr double kLeastAngle = 0.5 * kPi / 180;
    const Matrix3 mean = normal * (1 / sum);
    if (!(mean.determinant() > kLeastAngle * kLeastAngle / 4)) return std::nullopt;
    return right / sum * mean.inverse();  // it is symmetric
}

}  // namespace

std::optional<Vec3> middleOfViews(const std::vector<Pose>& views) {
    constexpr int kSteps = 50;
    constexpr double kNear = 1e-6;  ///< of the typical distance of cameras: lines count no more when they are nearer
    std::vector<Ray> axes;
    for (const Pose& pose : views)
        axes.push_back(pixelRay(pose.camera, 0.5 * pose.camera.width, 0.5 * pose.camera.height));
    std::optional<Vec3> middle = nearestPoint(axes, std::vector<double>(axes.size(), 1.0));
    if (!middle) return middle;
    std::vector<double> distances;
    for (const Ray& axis : axes) distances.push_back((axis.origin - *middle).length());
    const double near = std::max(kNear * quantile(distances, 0.5), std::numeric_limits<double>::min());
    for (int step = 0; step < kSteps && middle; ++step) {
        std::vector<double> weights;
        for (const Ray& axis : axes)
            weights.push_back(near / std::max(near, (*middle - axis.origin).cross(axis.direction).length()));
        const std::optional<Vec3> next = nearestPoint(axes, weights);
        if (!next) break;  // what is left is parallel
        middle = next;
    }
    return middle;
}

std::optional<Box3> boundsOfPoints(const Poses& poses) {
    constexpr std::size_t kEnough = 20;
    constexpr double kOutliers = 0.01, kMargin = 0.1;
    std::vector<Vec3> points = pointsSeenByHalf(poses);
    if (points.size() < kEnough) points = poses.points;
    if (points.size() < kEnough) return std::nullopt;
    Box3 box;
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<double> values;
        for (const Vec3& point : points) values.push_back(point[axis]);
        box.min[axis] = quantile(values, kOutliers);
        box.max[axis] = quantile(values, 1 - kOutliers);
    }
    // A tenth of the longest edge for those that are flat.
    const Vec3 size = box.size(), margin(kMargin * std::max({size.x, size.y, size.z}));
    return Box3(box.min - margin, box.max + margin);
}

Box3 boundsSeenByAll(const std::vector<Pose>& views) {
    const std::optional<Vec3> middle = middleOfViews(views);
    if (!middle)
        throw InvalidArgument(
            "where the object is does not follow from the cameras, which all look one way; give "
            "bounds");
    std::vector<double> radii;
    for (const Pose& pose : views) radii.push_back(radiusSeen(pose.camera, *middle));
    std::vector<double> sorted = radii;
    const double typical = quantile(sorted, 0.5);
    if (!(typical > 0))
        throw InvalidArgument(
            "the cameras look at no common place: less than half of them see the point that is "
            "nearest to the middles of all pictures; give bounds");
    std::vector<const PhotoCamera*> cameras;
    double radius = typical;
    for (std::size_t n = 0; n < views.size(); ++n)
        if (radii[n] > 0.25 * typical) {  // the others see it near their edge
            cameras.push_back(&views[n].camera);
            radius = std::min(radius, radii[n]);
        }
    // Pictures twice as wide as high, crosswise: nothing is farther than 2 √2 radii.
    const Vec3 reach(4 * radius);
    return shrunkWhileItPays(Box3(*middle - reach, *middle + reach), [&](const Box3& box) {
        const Cells cells(box);
        return boxOfKept(box, cells, [&](const Index3& cell) {
            const Vec3 center = cells.corner(cell) + Vec3(0.5 * cells.edge);
            return std::all_of(cameras.begin(), cameras.end(),
                               [&](const PhotoCamera* camera) { return sees(*camera, center); });
        });
    });
}

Box3 estimatedBounds(const Poses& poses) {
    if (poses.bounds) return *poses.bounds;
    if (const auto ofPoints = boundsOfPoints(poses)) return *ofPoints;
    return boundsSeenByAll(poses.views);
}

Box3 boundsOf(const std::vector<Photograph>& photographs, const Box3& start) {
    if (!start.hasVolume() || !isFinite(start.min) || !isFinite(start.max))
        throw InvalidArgument("bounds to begin with are empty or not finite");
    if (photographs.empty()) throw InvalidArgument("there are no photographs to find bounds with");
    std::vector<Silhouette> silhouettes;
    for (const Photograph& photograph : photographs) {
        requirePhotograph(photograph);
        silhouettes.emplace_back(photograph);
    }
    const Box3 box = shrunkWhileItPays(start, [&](const Box3& from) {
        const Cells cells(from);
        return boxOfKept(from, cells,
                         [&](const Index3& cell) { return isCovered(silhouettes, cells.corner(cell), cells.edge); });
    });
    if (box.isEmpty())
        throw InvalidArgument(
            "no place within the bounds is covered by the object in all photographs that show it: "
            "are the bounds too small, the mattes wrong, or the cameras' axes another program's?");
    return box;
}

}  // namespace raysweep
