// Variance-based division, as in colour quantization (Wan, Wong and Prusinkiewicz 1988): the group with the largest
// sum of squared distances is cut at its mean, across the axis along which it is widest. In three dimensions, so that
// neither the poles nor the picture's edges matter (median cut in the picture, Debevec 2005, has to care for both).
#include "raysweep/scene/sky_suns.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

/// Radians. Narrower groups are not divided: a sun of a degree's radius throws no softer shadows in a volume.
constexpr double kNarrow = 0.01;
/// Radians: a disc of 4 degrees' radius. A part of the sky that so many suns cannot cover is so large that sweep
/// directions find it often enough, and suns so far apart would show.
constexpr double kWide = 0.05;

struct Group {
    std::vector<int> cells;
    LightMoments light;
    bool divisible = true;
};

Group groupOfAll(const std::vector<LightMoments>& cells) {
    Group group;
    for (std::size_t i = 0; i < cells.size(); ++i)
        if (cells[i].power() > 0) {
            group.cells.push_back(int(i));
            group.light += cells[i];
        }
    return group;
}

/// Cuts `group` in two. @return the part taken away; without cells if all of them are in one place
Group cut(Group& group, const std::vector<LightMoments>& cells) {
    const Vec3 variance = group.light.variance(), mean = group.light.mean();
    const int axis = variance.x > variance.y ? (variance.x > variance.z ? 0 : 2) : (variance.y > variance.z ? 1 : 2);
    const auto below = [&](int cell) { return cells[std::size_t(cell)].mean()[axis] < mean[axis]; };
    const auto middle = std::stable_partition(group.cells.begin(), group.cells.end(), below);
    Group upper;
    if (middle == group.cells.begin() || middle == group.cells.end()) return upper;
    upper.cells.assign(middle, group.cells.end());
    group.cells.erase(middle, group.cells.end());
    group.light = LightMoments();
    for (const int cell : group.cells) group.light += cells[std::size_t(cell)];
    for (const int cell : upper.cells) upper.light += cells[std::size_t(cell)];
    return upper;
}

/// Sum of squared distances; 0 for what is not to be cut.
double unevenness(const Group& group) {
    const double spread = group.light.spread();
    return group.divisible && spread > kNarrow ? group.light.power() * spread * spread : 0;
}

void divide(std::vector<Group>& groups, int most, const std::vector<LightMoments>& cells) {
    while (int(groups.size()) < most) {
        const auto widest = std::max_element(
            groups.begin(), groups.end(), [](const Group& a, const Group& b) { return unevenness(a) < unevenness(b); });
        if (!(unevenness(*widest) > 0)) return;
        Group upper = cut(*widest, cells);
        if (upper.cells.empty())
            widest->divisible = false;
        else
            groups.push_back(std::move(upper));
    }
}

}  // namespace

void LightMoments::add(const Imath::Color3<double>& part, const Vec3& towards, double extent) {
    const double weight = (part.x + part.y + part.z) / 3;
    irradiance += part;
    first += towards * weight;
    // A square pixel's own mean squared distance from its middle, extent^2 / 6, spread over the three components.
    second += (towards * towards + Vec3(extent * extent / 18)) * weight;
}

LightMoments& LightMoments::operator+=(const LightMoments& other) {
    irradiance += other.irradiance;
    first += other.first;
    second += other.second;
    return *this;
}

Vec3 LightMoments::variance() const {
    const Vec3 m = mean();
    return second / power() - m * m;
}

double LightMoments::spread() const {
    const Vec3 v = variance();
    return std::sqrt(std::max(0.0, v.x + v.y + v.z));
}

std::vector<LightMoments> groupIntoSuns(const std::vector<LightMoments>& cells, int most, std::vector<int>& groupOf) {
    groupOf.assign(cells.size(), -1);
    std::vector<Group> groups{groupOfAll(cells)};
    if (groups.front().cells.empty() || most < 1) return {};
    divide(groups, most, cells);
    std::vector<LightMoments> suns;
    for (const Group& group : groups) {
        if (!(group.light.spread() <= kWide)) continue;
        for (const int cell : group.cells) groupOf[std::size_t(cell)] = int(suns.size());
        suns.push_back(group.light);
    }
    return suns;
}

}  // namespace raysweep
