#include "cube4/perspective.h"

#include "cube4/arithmetic.h"
#include "cube4/base_plane.h"
#include "cube4/fixed_point.h"

#include "raysweep/core/error.h"
#include "raysweep/core/require.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace raysweep::cube4 {
namespace {

constexpr double kNearest = 1;     ///< slices from the point to the first one that is passed
constexpr double kSteepest = 1.9;  ///< slope of a ray that is kept: the router takes it two voxels on in a slice
constexpr double kMost = 2;        ///< voxels from a ray to the next
constexpr double kApart = 1 + 1e-9;
constexpr double kLeastSpacing = 0.01, kMostRays = 64;  ///< passes grow with the square of both: no end beyond

Matrix3 rows(const Vec3& a, const Vec3& b, const Vec3& c) {
    return Matrix3(a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z);
}

/// Whether the half-line meets the memory's box.
bool meets(const Vec3& apex, const Vec3& way, const Index3& size) {
    double from = 0, to = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
        const double low = -apex[axis], high = size[axis] - 1 - apex[axis];
        if (way[axis] == 0) {
            if (low > 0 || high < 0) return false;
            continue;
        }
        const double a = low / way[axis], b = high / way[axis];
        from = std::max(from, std::min(a, b));
        to = std::min(to, std::max(a, b));
    }
    return from <= to;
}

/// The pixels of one front.
struct Pixels {
    double leastU = 1, mostU = -1, leastV = 1, mostV = -1;  ///< slopes
    double fromCentre = std::numeric_limits<double>::infinity();
    Imath::V2d middle{0, 0};  ///< the one next to the picture's centre

    bool any() const { return leastU <= mostU; }
    void add(const Vec3& way, const PerspectiveFront& front, const Imath::V2d& pixel, double distance) {
        const double along = std::abs(way[front.major]);
        const double u = way[front.axisU] / along, v = way[front.axisV] / along;
        leastU = std::min(leastU, u), mostU = std::max(mostU, u);
        leastV = std::min(leastV, v), mostV = std::max(mostV, v);
        if (distance < fromCentre) fromCentre = distance, middle = pixel;
    }
};

PerspectiveFront emptyFront(int major, bool up, const Vec3& apex) {
    PerspectiveFront front;
    front.major = major;
    front.axisU = major == 2 ? 1 : 2;
    front.axisV = major == 0 ? 1 : 0;
    front.up = up;
    front.apex = apex;
    return front;
}

/// The lattice: that of the pixels where they are in a plane of slices, and as close where they are not.
void chooseLattice(PerspectiveFront& front, const PointPlane& plane, const Imath::V2d& middle) {
    const auto slopes = [&](double column, double row) {
        const Vec3 way = plane.wayOf(middle.x + column, middle.y + row);
        return Imath::V2d(way[front.axisU], way[front.axisV]) / std::abs(way[front.major]);
    };
    const Imath::V2d at = slopes(0, 0), column = slopes(1, 0) - at, row = slopes(0, 1) - at;
    front.phaseU = at.x;
    front.phaseV = at.y;
    front.spacing =
        std::min(std::max(std::abs(column.x), std::abs(row.x)), std::max(std::abs(column.y), std::abs(row.y)));
    if (!(front.spacing > 0)) throw InvalidArgument("a view's pixels have no area as seen from its source or eye");
}

std::vector<Region> regionsOf(const PerspectiveFront& front, const MemoryBox& memory, double leastSpacing) {
    std::vector<Region> regions;
    int level = 0;
    const int slices = memory.box.size()[front.major];
    for (int n = 0; n < slices; ++n) {
        const double along = front.sliceAt(n, memory) - front.apex[front.major], distance = front.up ? along : -along;
        if (distance < kNearest) continue;
        const auto apart = [&](int at) { return front.spacingAt(at) * distance; };
        while (apart(level) >= kMost || (level > 0 && apart(level - 1) >= leastSpacing)) --level;
        while (apart(level) < leastSpacing) ++level;
        int sublattices = 1;
        while (sublattices * apart(level) < kApart) sublattices *= 2;
        if (regions.empty() || regions.back().level != level || regions.back().sublattices != sublattices)
            regions.push_back({n, n, level, sublattices});
        regions.back().end = n + 1;
    }
    return regions;
}

int halved(int value, int times, bool up) {
    for (int i = 0; i < times; ++i) value = up ? (value + 1) >> 1 : value >> 1;
    return value;
}

LatticeRange rangeOf(const PerspectiveFront& front, const Pixels& pixels) {
    const double spacing = front.spacingAt(front.regions.back().level);
    const auto low = [&](double slope, double phase) { return int(std::floor((slope - phase) / spacing)) - 1; };
    const auto high = [&](double slope, double phase) { return int(std::ceil((slope - phase) / spacing)) + 1; };
    return {low(pixels.leastU, front.phaseU), high(pixels.mostU, front.phaseU), low(pixels.leastV, front.phaseV),
            high(pixels.mostV, front.phaseV)};
}

/// Where the rays of one coordinate are in the slices of a pass, along u or v.
class Track {
  public:
    Track(const Traversal& traversal, const PerspectiveFront& front, int lateral)
        : traversal_(traversal),
          sense_(traversal.descending ? -1 : 1),
          apex_(front.apex[lateral == 0 ? front.axisU : front.axisV]),
          origin_(traversal.origin[lateral == 0 ? front.axisU : front.axisV]),
          last_(traversal.size[lateral] - 2),
          major_(front.apex[front.major]) {}

    double at(double slope, int k) const { return sense_ * (apex_ + slope * distance(k) - origin_); }
    /// The voxel below the ray, -1 outside.
    int cellOf(double slope, int k) const {
        if (k < 0 || k >= traversal_.size.z) return -1;
        const double cell = std::floor(at(slope, k));
        return cell >= 0 && cell <= last_ ? int(cell) : -1;
    }
    double sense() const { return sense_; }

  private:
    double distance(int k) const { return std::abs(traversal_.memoryCoordinate(traversal_.major, k) - major_); }

    const Traversal& traversal_;
    double sense_, apex_, origin_;
    int last_;
    double major_;
};

/// Rays low, low + stride ... high of a lattice.
struct Rays {
    int low, high, stride;
    double phase, spacing;
};

bool isKept(double slope) {
    return std::abs(slope) <= kSteepest;
}

/// A region's slices, all of each.
Traversal wholeTraversal(const Journey& journey, const Region& region) {
    const PerspectiveFront& front = journey.front;
    const Index3 size = journey.memory.size();
    const int from = front.sliceAt(region.first, journey.memory), to = front.sliceAt(region.end - 1, journey.memory);
    ContentBox content{Index3(0), size};
    content.low[front.major] = std::min(from, to);
    content.high[front.major] = std::max(from, to) + 1;
    Direction along;
    along.alongIndex = Vec3(0);
    along.alongIndex[front.major] = front.up == (journey.order == RayOrder::diverging) ? 1 : -1;
    return traverse(size, content, along, Resampling::linear);
}

/// Leaves out voxels along u or v that no ray of the pass meets.
void crop(Traversal& traversal, const PerspectiveFront& front, int lateral, const Rays& rays) {
    const Track track(traversal, front, lateral);
    int low = traversal.size[lateral] - 2, high = 0;
    for (int i = rays.low; i <= rays.high; i += rays.stride)
        for (const int k : {0, traversal.size.z - 1}) {
            const double slope = rays.phase + i * rays.spacing;
            if (!isKept(slope)) continue;
            const double at = std::clamp(std::floor(track.at(slope, k)), 0.0, double(traversal.size[lateral] - 2));
            low = std::min(low, int(at)), high = std::max(high, int(at));
        }
    if (low > high) return;
    traversal.size[lateral] = high - low + 2;
    int& origin = traversal.origin[lateral == 0 ? traversal.axisU : traversal.axisV];
    origin += traversal.descending ? -low : low;
}

template <class Arithmetic>
std::vector<Place<typename Arithmetic::Weight>> placesOf(const Arithmetic& arithmetic, const Track& track,
                                                         const Rays& rays, int voxels, int k) {
    using Weight = typename Arithmetic::Weight;
    std::vector<Place<Weight>> places(std::size_t(voxels) + 1);
    std::vector<Between<Weight>> weights(places.size());
    for (int i = rays.low; i <= rays.high; i += rays.stride) {
        const double slope = rays.phase + i * rays.spacing;
        const int cell = isKept(slope) ? track.cellOf(slope, k) : -1;
        if (cell < 0) continue;
        Place<Weight>& place = places[std::size_t(cell)];
        place.hasRay = true;
        place.ray = i;
        place.from = track.cellOf(slope, k - 1);
        place.to = track.cellOf(slope, k + 1);
        place.slope = track.sense() * slope;
        Between<Weight>& weight = weights[std::size_t(cell)];
        weight.high = arithmetic.weight(track.at(slope, k) - cell);
        weight.low = arithmetic.weight(1) - weight.high;
    }
    for (std::size_t u = 0; u < places.size(); ++u) {
        places[u].ending = u > 0 ? weights[u - 1] : Between<Weight>{};
        places[u].atVoxel = {weights[u].low, places[u].ending.high};
    }
    places.pop_back();
    return places;
}

}  // namespace

void RaySampling::validate() const {
    requireField(leastSpacing >= kLeastSpacing && leastSpacing <= 1, "leastSpacing", leastSpacing, "in [0.01,1]");
    requireField(raysPerPixel >= 1 && raysPerPixel <= kMostRays, "raysPerPixel", raysPerPixel, "in [1,64]");
}

LatticeRange PerspectiveFront::rangeAt(int level) const {
    const int times = level - regions.back().level;
    return {halved(range.lowU, times, false), halved(range.highU, times, true), halved(range.lowV, times, false),
            halved(range.highV, times, true)};
}

Vec3 PerspectiveFront::wayOf(double u, double v, int level) const {
    Vec3 way;
    way[major] = up ? 1 : -1;
    way[axisU] = phaseU + u * spacingAt(level);
    way[axisV] = phaseV + v * spacingAt(level);
    return way;
}

Imath::V2d PerspectiveFront::rayOf(const Vec3& way, int level) const {
    const double along = std::abs(way[major]);
    return {snapped((way[axisU] / along - phaseU) / spacingAt(level)),
            snapped((way[axisV] / along - phaseV) / spacingAt(level))};
}

double PerspectiveFront::lengthOf(const Vec3& way, const Matrix3& worldFromIndex) const {
    return (way * worldFromIndex).length() / std::abs(way[major]);
}

double PerspectiveFront::longest(const Matrix3& worldFromIndex) const {
    double longest = 0;
    for (const int u : {range.lowU, range.highU})
        for (const int v : {range.lowV, range.highV})
            longest = std::max(longest, lengthOf(wayOf(u, v, regions.back().level), worldFromIndex));
    return longest;
}

int PerspectiveFront::sliceAt(int n, const MemoryBox& memory) const {
    return memory.pad + (up ? n : memory.box.size()[major] - 1 - n);
}

PointPlane::PointPlane(const PointRays& pixels, const MemoryBox& memory) {
    const Matrix3 memoryFromWorld = memory.box.worldFromIndex.inverse();
    apex_ = (pixels.source - memory.origin) * memoryFromWorld + Vec3(double(memory.pad));
    first_ = (pixels.origin - pixels.source) * memoryFromWorld;
    columns_ = pixels.column * memoryFromWorld;
    rows_ = pixels.row * memoryFromWorld;
    const Matrix3 wayFromPixel = rows(columns_, rows_, first_);
    if (!(std::abs(wayFromPixel.determinant()) > 0))
        throw InvalidArgument("a view's pixels have no area as seen from its source or eye");
    pixelFromWay_ = wayFromPixel.inverse();
}

Imath::V2d PointPlane::pixelOf(const Vec3& way) const {
    const Vec3 at = way * pixelFromWay_;
    if (!(at.z > 0)) return {std::nan(""), std::nan("")};
    return {snapped(at.x / at.z), snapped(at.y / at.z)};
}

std::vector<PerspectiveFront> frontsOf(const PointRays& pixels, const MemoryBox& memory, const RaySampling& sampling) {
    sampling.validate();
    const PointPlane plane(pixels, memory);
    std::vector<PerspectiveFront> fronts;
    for (int major = 0; major < 3; ++major)
        for (const bool up : {false, true}) fronts.push_back(emptyFront(major, up, plane.apex()));
    std::array<Pixels, 6> of;
    for (int row = 0; row < pixels.height; ++row)
        for (int column = 0; column < pixels.width; ++column) {
            const Vec3 way = plane.wayOf(column, row);
            if (!meets(plane.apex(), way, memory.size())) continue;
            const int major = majorAxis(way);
            const std::size_t n = std::size_t(2 * major + (way[major] > 0 ? 1 : 0));
            of[n].add(way, fronts[n], {double(column), double(row)},
                      std::hypot(column - 0.5 * (pixels.width - 1), row - 0.5 * (pixels.height - 1)));
        }
    std::vector<PerspectiveFront> used;
    for (std::size_t n = 0; n < fronts.size(); ++n) {
        if (!of[n].any()) continue;
        chooseLattice(fronts[n], plane, of[n].middle);
        fronts[n].spacing /= sampling.raysPerPixel;
        fronts[n].regions = regionsOf(fronts[n], memory, sampling.leastSpacing);
        if (fronts[n].regions.empty()) continue;
        fronts[n].range = rangeOf(fronts[n], of[n]);
        used.push_back(fronts[n]);
    }
    return used;
}

template <class Arithmetic>
RegionPass<typename Arithmetic::Weight> regionPass(const Arithmetic& arithmetic, const Journey& journey,
                                                   const Region& region, const Imath::V2i& sublattice) {
    const PerspectiveFront& front = journey.front;
    RegionPass<typename Arithmetic::Weight> pass;
    Traversal& traversal = pass.traversal;
    traversal = wholeTraversal(journey, region);
    const LatticeRange range = front.rangeAt(region.level);
    const int stride = region.sublattices;
    const auto raysOf = [&](int low, int high, double phase, int remainder) {
        const int first = low + ((remainder - low) % stride + stride) % stride;
        return Rays{first, high, stride, phase, front.spacingAt(region.level)};
    };
    const Rays u = raysOf(range.lowU, range.highU, front.phaseU, sublattice.x);
    const Rays v = raysOf(range.lowV, range.highV, front.phaseV, sublattice.y);
    pass.grouped = stride > 1;
    pass.lastOfRegion = sublattice.x == stride - 1 && sublattice.y == stride - 1;
    if (!journey.settles || !pass.lastOfRegion) {
        crop(traversal, front, 0, u);
        crop(traversal, front, 1, v);
    }
    const Track trackU(traversal, front, 0), trackV(traversal, front, 1);
    pass.slices.resize(std::size_t(traversal.size.z));
    for (int k = 0; k < traversal.size.z; ++k) {
        auto& slice = pass.slices[std::size_t(k)];
        slice.number = k;
        slice.first = k == 0;
        slice.last = k == traversal.size.z - 1;
        slice.hops = 1 - 2 * journey.ending;
        slice.placesU = placesOf(arithmetic, trackU, u, traversal.size.x, k);
        slice.placesV = placesOf(arithmetic, trackV, v, traversal.size.y, k);
    }
    return pass;
}

template RegionPass<float> regionPass(const FloatArithmetic&, const Journey&, const Region&, const Imath::V2i&);
template RegionPass<FixedPoint::Weight> regionPass(const FixedPoint&, const Journey&, const Region&, const Imath::V2i&);

}  // namespace raysweep::cube4
