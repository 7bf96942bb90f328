#include "raysweep/reconstruct/photo_sightings.h"

#include "raysweep/core/directions.h"
#include "raysweep/core/parallel.h"
#include "raysweep/projector/composite.h"
#include "raysweep/reconstruct/photo_views.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace raysweep {
namespace {

/// How bright a place is in one view.
struct Sighting {
    float weight = 0, brightness = 0;
    float normal[3] = {0, 0, 0};  ///< as if the object stood still, and the camera where the first was
};

/// Sightings of all places, `views` for each.
struct Sightings {
    std::size_t views = 0;
    std::vector<Sighting> all;

    std::size_t places() const { return all.size() / views; }
    const Sighting* of(std::size_t place) const { return all.data() + place * views; }
};

/// Gives a sample the square of its visibility, and that times the brightness it is seen in, as red: its own, and of
/// what the picture shows more than the volume the part that the shortest way to the picture gives it.
std::array<float, 3> sightRule(const PhotoRays& rays, std::size_t r, const RaySamples& s, SampleShare* shares) {
    const auto& pixel = rays.pixels[r];
    const float more = (pixel[0] + pixel[1] + pixel[2]) - (s.color.red + s.color.green + s.color.blue);
    float squares = 1e-4f;
    for (std::size_t i = 0; i < s.count; ++i) {
        const float seen = s.transmittances[i] - s.transmittances[i + 1];
        squares += seen * seen;
    }
    for (std::size_t i = 0; i < s.count; ++i) {
        const float seen = s.transmittances[i] - s.transmittances[i + 1];
        const float weight = rays.shares[r].at(s.numbers[i]) * seen * seen;
        const CompositeVoxel& c = s.samples[i];
        shares[i] = {weight, weight * (c.red + c.green + c.blue + seen * more / squares)};
    }
    return {1, 0, 0};
}

/// What all pictures show of all voxels: Σ w and Σ w b, view after view.
std::vector<std::vector<CompositeVoxel>> sightAll(const std::vector<Photograph>& pictures,
                                                  const PhotoSurfaces& surfaces) {
    std::vector<std::vector<CompositeVoxel>> sums(pictures.size());
    PhotoRays rays;
    CompositeTape tape;
    for (std::size_t n = 0; n < pictures.size(); ++n) {
        sums[n].resize(surfaces.layout.voxelCount());
        setRays(rays, pictures[n], surfaces.grid, surfaces.layout, 1, 0);
        const auto rule = [&](std::size_t r, const RaySamples& samples, SampleShare* shares) {
            return sightRule(rays, r, samples, shares);
        };
        compositeSpread(surfaces.layout, surfaces.voxels.data(), rays.rays, rule, tape, sums[n].data());
    }
    return sums;
}

/// The voxels that are seen best, at most `most`.
std::vector<std::size_t> bestSeen(const std::vector<std::vector<CompositeVoxel>>& sums, const PhotoSurfaces& surfaces,
                                  std::size_t most) {
    std::vector<std::pair<float, std::size_t>> ranked;
    for (std::size_t i = 512; i < surfaces.voxels.size(); ++i) {
        float weight = 0;
        for (const auto& view : sums) weight += view[i].extinction;
        if (weight > 0 && surfaces.normals[i].isSurface()) ranked.emplace_back(-weight, i);
    }
    std::sort(ranked.begin(), ranked.end());
    ranked.resize(std::min(ranked.size(), most));
    std::vector<std::size_t> best;
    for (const auto& [weight, i] : ranked) best.push_back(i);
    return best;
}

Sightings sightingsOf(const std::vector<Photograph>& pictures, const PhotoSurfaces& surfaces, std::size_t places) {
    const auto sums = sightAll(pictures, surfaces);
    Sightings to;
    to.views = pictures.size();
    for (const std::size_t i : bestSeen(sums, surfaces, places))
        for (std::size_t n = 0; n < to.views; ++n) {
            const CompositeVoxel& sum = sums[n][i];
            const Vec3 normal =
                carriedAlong(unpacked(surfaces.normals[i]), pictures[n].camera, pictures.front().camera);
            const float brightness = sum.extinction > 0 ? sum.red / sum.extinction : 0;
            to.all.push_back({sum.extinction, brightness, {float(normal.x), float(normal.y), float(normal.z)}});
        }
    return to;
}

/// Of a place's sightings what eq. 2 needs for a direction: with the three terms of eq. 1, sums of w b times each, and
/// of w times products of two, of which one is 0.
struct PlaceSums {
    float byTerm[3] = {0, 0, 0};
    float weight = 0, first = 0, second = 0, firstSquare = 0, secondSquare = 0;

    PlaceSums(const Sighting* s, std::size_t views, const float* light) {
        for (std::size_t n = 0; n < views; ++n) {
            const float away = s[n].normal[0] * light[0] + s[n].normal[1] * light[1] + s[n].normal[2] * light[2];
            const float towards = std::max(0.0f, -away), beyond = std::max(0.0f, away);
            const float w = s[n].weight, b = s[n].brightness;
            byTerm[0] += w * b;
            byTerm[1] += w * b * towards;
            byTerm[2] += w * b * beyond;
            weight += w;
            first += w * towards;
            second += w * beyond;
            firstSquare += w * towards * towards;
            secondSquare += w * beyond * beyond;
        }
    }
    float bf(const float* a) const { return a[0] * byTerm[0] + a[1] * byTerm[1] + a[2] * byTerm[2]; }
    float ff(const float* a) const {
        return a[0] * (a[0] * weight + 2 * (a[1] * first + a[2] * second)) + a[1] * a[1] * firstSquare +
               a[2] * a[2] * secondSquare;
    }
};

/// Sums of PlaceSums over all places, each times its colour or that squared.
struct TermSums {
    double byTerm[3] = {0, 0, 0};
    double weight = 0, first = 0, second = 0, firstSquare = 0, secondSquare = 0;
    double explained = 0;  ///< what eq. 2 subtracts
};

TermSums sumTerms(const std::vector<PlaceSums>& places, const float* terms) {
    TermSums all;
    for (const PlaceSums& place : places) {
        const float bf = place.bf(terms), ff = place.ff(terms);
        if (!(ff > 0)) continue;
        const double color = bf / ff, square = color * color;
        all.explained += color * bf;
        for (int i = 0; i < 3; ++i) all.byTerm[i] += color * place.byTerm[i];
        all.weight += square * place.weight;
        all.first += square * place.first;
        all.second += square * place.second;
        all.firstSquare += square * place.firstSquare;
        all.secondSquare += square * place.secondSquare;
    }
    return all;
}

struct Guess {
    Vec3 light;
    double explained = -1;
    float terms[3] = {0.6f, 0.4f, 0};  ///< α of eq. 1; the first two together are 1
};

/// The terms that suit one direction, by turns with the colours.
Guess guessFor(const Sightings& sightings, const Vec3& direction) {
    constexpr int kTurns = 10, kSweeps = 20;
    const float light[3] = {float(direction.x), float(direction.y), float(direction.z)};
    std::vector<PlaceSums> places;
    for (std::size_t p = 0; p < sightings.places(); ++p) places.emplace_back(sightings.of(p), sightings.views, light);
    Guess guess;
    guess.light = direction;
    for (int turn = 0; turn < kTurns; ++turn) {
        const TermSums sums = sumTerms(places, guess.terms);
        guess.explained = sums.explained;
        if (turn == kTurns - 1 || !(sums.weight > 0)) break;
        double a[3] = {guess.terms[0], guess.terms[1], guess.terms[2]};
        for (int sweep = 0; sweep < kSweeps; ++sweep) {  // one after the other, within their bounds
            a[0] = std::max(0.0, (sums.byTerm[0] - sums.first * a[1] - sums.second * a[2]) / sums.weight);
            if (sums.firstSquare > 0) a[1] = std::max(0.0, (sums.byTerm[1] - sums.first * a[0]) / sums.firstSquare);
            if (sums.secondSquare > 0)
                a[2] = std::clamp((sums.byTerm[2] - sums.second * a[0]) / sums.secondSquare, 0.0, a[1]);
        }
        const double all = a[0] + a[1];
        for (int i = 0; i < 3; ++i) guess.terms[i] = all > 0 ? float(a[i] / all) : float(i == 0);
    }
    return guess;
}

void improve(Guess& best, const Guess& other) {
    if (other.explained > best.explained) best = other;
}

/// Smaller and smaller steps.
Guess refined(const Sightings& sightings, Guess best) {
    constexpr double kFirst = 0.12, kLast = 0.01;  // radians
    for (double step = kFirst; step > kLast; step *= 0.5)
        for (bool moved = true; moved;) {
            const Guess from = best;
            const Vec3 u = from.light.cross(axisAside(from.light)).normalized(), v = from.light.cross(u);
            for (const Vec3& change : {u, v, u * -1.0, v * -1.0})
                improve(best, guessFor(sightings, (from.light + change * step).normalized()));
            moved = best.explained > from.explained;
        }
    return best;
}

/// Evenly over the sphere, as the cameras of a rig.
std::vector<Vec3> evenDirections(int count) {
    std::vector<Vec3> directions;
    for (int i = 0; i < count; ++i) {
        const double z = 1 - (2 * i + 1.0) / count, level = std::sqrt(1 - z * z);
        const double angle = i * kPi * (3 - std::sqrt(5.0));
        directions.emplace_back(level * std::cos(angle), level * std::sin(angle), z);
    }
    return directions;
}

}  // namespace

Shading guessLight(const std::vector<Photograph>& pictures, const PhotoSurfaces& surfaces, std::size_t places,
                   int directions) {
    const Sightings sightings = sightingsOf(pictures, surfaces, places);
    const std::vector<Vec3> all = evenDirections(directions);
    std::vector<Guess> guesses(all.size());
    parallelFor(all.size(), [&](std::size_t i) { guesses[i] = guessFor(sightings, all[i]); });
    Guess best = guesses.front();
    for (const Guess& guess : guesses) improve(best, guess);
    best = refined(sightings, best);
    Shading shading;
    shading.diffuse = best.terms[1];
    shading.ambient = 1 - shading.diffuse;
    shading.light = best.light;
    return shading;
}

}  // namespace raysweep
