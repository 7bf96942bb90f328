// A few hundred sweep directions cannot be trusted to find a sun of a hundred-thousandth of the sphere. So what is much
// brighter than the mean is taken out of the map and, where it is small, handed to the direct pass as suns; what is
// left is nowhere much brighter than the mean, and a random direction stands for the whole sphere well.
#include "raysweep/scene/sky_map.h"

#include "raysweep/core/require.h"
#include "raysweep/scene/sky_suns.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

namespace raysweep {
namespace {

using Color64 = Imath::Color3<double>;

/// Times the mean of the sphere: what is brighter stands out. A quarter of the sphere in white on black does not.
constexpr double kStandsOut = 4;
/// Cells in which what stands out is collected; they keep its exact mean direction.
constexpr int kMostCellRows = 256;
/// Rows of the averaged sky.
constexpr int kMostSkyRows = 32;

double meanOf(const Color64& c) {
    return (c.x + c.y + c.z) / 3;
}

Color64 pixelOf(const Image& map, int x, int y) {
    const float* const p = map.at(x, y);
    return map.channels < 3 ? Color64(double(p[0])) : Color64(double(p[0]), double(p[1]), double(p[2]));
}

void requireLatLong(const Image& map) {
    const std::string size = std::to_string(map.width) + " x " + std::to_string(map.height) + " pixels";
    // Some programs round a half-sized map's width up.
    if (std::abs(map.width - 2 * map.height) > 1)
        throw InvalidArgument("a sky map must be a lat-long picture, twice as wide as high; this one has " + size);
    if (map.width < 4 || map.height < 2)
        throw InvalidArgument("a sky map must have at least 4 x 2 pixels; this one has " + size);
    if (map.channels < 1) throw InvalidArgument("a sky map needs a channel");
}

/// @return true if all pixels are grey
bool requireLight(const Image& map) {
    bool greyEverywhere = true;
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            const Color64 color = pixelOf(map, x, y);
            for (int c = 0; c < 3; ++c) {
                if (std::isfinite(color[c]) && color[c] >= 0) continue;
                std::ostringstream text;
                text << "the sky map's pixel in column " << x << ", row " << y << " (from the top left, from 0) is "
                     << color[c] << "; radiance must be finite and not negative";
                throw InvalidArgument(text.str());
            }
            greyEverywhere = greyEverywhere && color.x == color.y && color.y == color.z;
        }
    return greyEverywhere;
}

/// Calls `visit(x, y, radiance, solid angle)` for every pixel.
template <class Visit>
void forEachPixel(const Image& map, const Visit& visit) {
    const LatLong pixels{map.width, map.height};
    for (int y = 0; y < map.height; ++y) {
        const double solidAngle = pixels.solidAngle(y);
        for (int x = 0; x < map.width; ++x) visit(x, y, pixelOf(map, x, y), solidAngle);
    }
}

/// What stands out, and in which cell of a coarser division of the sphere each of its pixels lies.
struct BrightParts {
    double limit = 0;  ///< of the mean of the wavelengths
    LatLong cells;
    std::vector<LightMoments> light;

    /// Part of a pixel's radiance that is above the limit.
    double excess(const Color64& radiance) const {
        const double mean = meanOf(radiance);
        return mean > limit ? (mean - limit) / mean : 0;
    }
    std::size_t cellOf(const Image& map, int x, int y) const {
        const int column = int(std::int64_t(x) * cells.width / map.width);
        const int row = int(std::int64_t(y) * cells.height / map.height);
        return std::size_t(row) * cells.width + column;
    }
};

BrightParts findBrightParts(const Image& map, double meanRadiance) {
    BrightParts parts;
    parts.limit = kStandsOut * meanRadiance;
    parts.cells.height = std::min(map.height, kMostCellRows);
    parts.cells.width = std::min(map.width, 2 * parts.cells.height);
    parts.light.resize(std::size_t(parts.cells.width) * parts.cells.height);
    const LatLong pixels{map.width, map.height};
    forEachPixel(map, [&](int x, int y, const Color64& radiance, double solidAngle) {
        const double excess = parts.excess(radiance);
        if (excess > 0)
            parts.light[parts.cellOf(map, x, y)].add(radiance * (excess * solidAngle), pixels.direction(x, y),
                                                     kPi / map.height);
    });
    return parts;
}

/// Averages of what suns do not stand for, over the cells of a coarser division.
struct AveragedSky {
    LatLong cells;
    std::vector<Color64> radiance;
};

/// Overlap of pixel [i, i+1) of `from` with the cells it touches of `to`: calls `visit(cell, begin, end)` in units of
/// the whole, ascending.
template <class Visit>
void forEachOverlap(int i, int from, int to, const Visit& visit) {
    const double begin = double(i) / from, end = double(i + 1) / from;
    for (int cell = int(std::int64_t(i) * to / from); cell < to && double(cell) / to < end; ++cell)
        visit(cell, std::max(begin, double(cell) / to), std::min(end, double(cell + 1) / to));
}

/// A map, and what of it suns stand for.
struct SunnyMap {
    const Image& map;
    const BrightParts& parts;
    const std::vector<int>& sunOf;  ///< for each cell of `parts` its sun, or -1; empty: there are none
};

/// Adds row `y` of the map, as far as suns do not stand for it, to the cells of one row; `height` is their overlap in
/// z.
void addRow(const SunnyMap& from, int y, double height, Color64* cells, int cellCount) {
    const auto& [map, parts, sunOf] = from;
    for (int x = 0; x < map.width; ++x) {
        const Color64 radiance = pixelOf(map, x, y);
        const bool inSun = !sunOf.empty() && sunOf[parts.cellOf(map, x, y)] >= 0;
        const Color64 left = radiance * (inSun ? 1 - parts.excess(radiance) : 1.0);
        forEachOverlap(x, map.width, cellCount, [&](int cell, double begin, double end) {
            cells[cell] += left * (height * 2 * kPi * (end - begin));
        });
    }
}

AveragedSky averaged(const SunnyMap& from) {
    const Image& map = from.map;
    AveragedSky sky;
    sky.cells.height = std::min(map.height, kMostSkyRows);
    sky.cells.width = std::min(map.width, 2 * sky.cells.height);
    sky.radiance.assign(std::size_t(sky.cells.width) * sky.cells.height, Color64(0));
    for (int y = 0; y < map.height; ++y)
        forEachOverlap(y, map.height, sky.cells.height, [&](int row, double top, double bottom) {
            const double height = std::cos(kPi * top) - std::cos(kPi * bottom);
            addRow(from, y, height, sky.radiance.data() + std::size_t(row) * sky.cells.width, sky.cells.width);
        });
    for (int row = 0; row < sky.cells.height; ++row)
        for (int column = 0; column < sky.cells.width; ++column)
            sky.radiance[std::size_t(row) * sky.cells.width + column] /= sky.cells.solidAngle(row);
    return sky;
}

Sky skyFrom(const AveragedSky& averages, const MapFrame& frame, double scale, bool coloured) {
    Color64 largest(0);
    for (const Color64& radiance : averages.radiance)
        for (int c = 0; c < 3; ++c) largest[c] = std::max(largest[c], radiance[c]);
    std::vector<Color> factors;
    for (const Color64& radiance : averages.radiance) {
        Color factor = grey(0);
        for (int c = 0; c < 3; ++c)
            if (largest[c] > 0) factor[c] = float(radiance[c] / largest[c]);
        factors.push_back(factor);
    }
    Sky sky;
    sky.radiance = Color(largest * scale);
    sky.colouredProfile = coloured;
    sky.profile = [cells = averages.cells, frame, factors = std::move(factors)](const Vec3& direction) {
        const Vec3 towards = frame.fromWorld(-direction);
        return factors[std::size_t(cells.row(towards)) * cells.width + cells.column(towards)];
    };
    return sky;
}

MapFrame frameFrom(const SkyMapOptions& options) {
    // Quarter turns are exact, so that a scene turned by one meets the same light.
    const double turns = options.rotate / 90;
    if (turns == std::floor(turns)) {
        const int quarter = int(std::fmod(std::fmod(turns, 4) + 4, 4));
        return {options.up,
                quarter == 0   ? 1.0
                : quarter == 2 ? -1.0
                               : 0.0,
                quarter == 1   ? 1.0
                : quarter == 3 ? -1.0
                               : 0.0};
    }
    const double angle = options.rotate * kPi / 180;
    return {options.up, std::cos(angle), std::sin(angle)};
}

}  // namespace

void SkyMapOptions::validate() const {
    requireField(up >= 0 && up <= 2, "up", up, "0, 1 or 2");
    requireField(std::isfinite(rotate), "rotate", rotate, "finite");
    requireField(scale >= 0 && std::isfinite(scale), "scale", scale, "finite and not negative");
    requireField(suns >= 0 && suns <= kMostSkySuns, "suns", suns, "in [0, 1024]");
}

SkyMapLight lightFromSkyMap(const Image& map, const SkyMapOptions& options) {
    options.validate();
    requireLatLong(map);
    const bool coloured = !requireLight(map);
    const MapFrame frame = frameFrom(options);

    double power = 0;  // of the whole sphere: the integral of radiance over solid angle
    forEachPixel(map,
                 [&](int, int, const Color64& radiance, double solidAngle) { power += meanOf(radiance) * solidAngle; });
    const BrightParts parts = findBrightParts(map, power / (4 * kPi));
    std::vector<int> sunOf;
    SkyMapLight light;
    double inSuns = 0;
    for (const LightMoments& sun : groupIntoSuns(parts.light, options.suns, sunOf)) {
        light.suns.push_back({-frame.toWorld(sun.first.normalized()), Color(sun.irradiance * options.scale)});
        inSuns += sun.power();
    }
    light.sunShare = power > 0 ? inSuns / power : 0;
    light.sky = skyFrom(averaged({map, parts, sunOf}), frame, options.scale, coloured);
    return light;
}

}  // namespace raysweep
