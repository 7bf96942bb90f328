#include "support/monte_carlo.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <stdexcept>
#include <string>

#include "raysweep/core/parallel.h"
#include "support/phase_function.h"

namespace raysweep::test {
namespace {

// Everything below works in voxel units: the box is [0,nx] x [0,ny] x [0,nz], and extinction is optical depth per
// voxel.

constexpr int kBatches = 64;       ///< fixed, so that results and error estimates do not depend on the machine
constexpr int kBatchesAtOnce = 8;  ///< bounds the memory for private tallies
constexpr int kDimensions = 7;     ///< random numbers of a packet's first flight: 6 for its start, 1 for its length

/// xoshiro256++ 1.0 (Blackman & Vigna 2019), its state filled by splitmix64.
class Random {
  public:
    explicit Random(std::uint64_t seed) {
        for (std::uint64_t& word : state_) {
            std::uint64_t z = (seed += 0x9e3779b97f4a7c15u);
            z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
            z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
            word = z ^ (z >> 31);
        }
    }

    std::uint64_t bits() {
        const std::uint64_t result = rotate(state_[0] + state_[3], 23) + state_[0], t = state_[1] << 17;
        state_[2] ^= state_[0];
        state_[3] ^= state_[1];
        state_[1] ^= state_[2];
        state_[0] ^= state_[3];
        state_[2] ^= t;
        state_[3] = rotate(state_[3], 45);
        return result;
    }

    /// In the open interval (0, 1).
    double uniform() { return (double(bits() >> 12) + 0.5) * 0x1p-52; }

  private:
    static std::uint64_t rotate(std::uint64_t x, int k) { return (x << k) | (x >> (64 - k)); }
    std::uint64_t state_[4];
};

using Sample = std::array<double, kDimensions>;

/// Evenly spread points (Roberts' R_d sequence, powers of the root of x^(d+1) = x + 1) moved by one random vector: each
/// point alone is uniform, so estimates stay unbiased and batches independent, while the light's own noise gets small.
class SpreadPoints {
  public:
    SpreadPoints(Random& random, bool even) : random_(random), even_(even) {
        double root = 1.5;
        for (int i = 0; i < 60; ++i) root = std::pow(1 + root, 1.0 / (kDimensions + 1));
        for (int d = 0; d < kDimensions; ++d) {
            step_[d] = std::pow(root, -(d + 1));
            point_[d] = random.uniform();
        }
    }

    const Sample& next() {
        for (int d = 0; d < kDimensions; ++d) {
            if (!even_) {
                point_[d] = random_.uniform();
                continue;
            }
            point_[d] += step_[d];
            if (point_[d] >= 1) point_[d] -= 1;
        }
        return point_;
    }

  private:
    Random& random_;
    bool even_;
    Sample step_, point_;
};

struct Box {
    int size[3];
    std::ptrdiff_t stride[3];
    bool periodic[3];

    double faceArea(int axis) const { return double(size[(axis + 1) % 3]) * double(size[(axis + 2) % 3]); }
};

/// A voxel's properties and its tally side by side, so that a step touches one cache line.
struct Cell {
    double path = 0;  ///< sum of packet power times track length
    float tau = 0;    ///< optical depth of one voxel edge
    float albedo = 0;
};

struct Packet {
    double position[3];
    double direction[3];
    int cell[3];
    double power;
};

/// Starts packets of one light; `start` maps six uniform numbers to position and direction.
struct Emitter {
    double power;  ///< [W]
    std::function<void(const Sample&, Packet&)> start;
};

struct Totals {
    double injected = 0, absorbed = 0;
    std::array<double, 6> escaped{}, uncollided{};
};

// ---------------------------------------------------------------------------------------------------------- lights

/// Picks one of the weights with a uniform number and makes that number uniform again.
std::size_t pick(const std::vector<double>& cumulative, double& u) {
    const double x = u * cumulative.back();
    std::size_t i = std::size_t(std::upper_bound(cumulative.begin(), cumulative.end(), x) - cumulative.begin());
    i = std::min(i, cumulative.size() - 1);
    const double low = i > 0 ? cumulative[i - 1] : 0.0, width = cumulative[i] - low;
    u = width > 0 ? std::min(std::max((x - low) / width, 0.0), 1.0) : 0.5;
    return i;
}

void locate(const Box& box, Packet& packet) {
    for (int a = 0; a < 3; ++a)
        packet.cell[a] = std::min(std::max(int(std::floor(packet.position[a])), 0), box.size[a] - 1);
}

/// Puts the packet on a face, at fractions u and v of its edges.
void placeOnFace(const Box& box, int face, double u, double v, Packet& packet) {
    const int axis = face / 2, b = (axis + 1) % 3, c = (axis + 2) % 3;
    packet.position[axis] = face % 2 ? box.size[axis] : 0;
    packet.position[b] = u * box.size[b];
    packet.position[c] = v * box.size[c];
    locate(box, packet);
}

void isotropicDirection(double u, double v, double* direction) {
    const double z = 1 - 2 * u, r = std::sqrt(std::max(0.0, 1 - z * z));
    direction[0] = r * std::cos(2 * kPi * v);
    direction[1] = r * std::sin(2 * kPi * v);
    direction[2] = z;
}

Emitter sunEmitter(const McSun& sun, const Box& box, double h) {
    const Vec3 d = sun.direction.normalized();
    std::vector<double> cumulative;
    double area = 0;
    for (int a = 0; a < 3; ++a) {
        area += box.periodic[a] ? 0.0 : std::abs(d[a]) * box.faceArea(a);
        cumulative.push_back(area);
    }
    return {sun.irradiance * area * h * h, [=](const Sample& s, Packet& packet) {
                double u = s[0];
                const int axis = int(pick(cumulative, u));
                placeOnFace(box, 2 * axis + (d[axis] < 0 ? 1 : 0), s[1], s[2], packet);
                for (int a = 0; a < 3; ++a) packet.direction[a] = d[a];
            }};
}

Emitter skyEmitter(const McSky& sky, const Box& box, double h) {
    std::vector<double> cumulative;
    double area = 0;
    for (int face = 0; face < 6; ++face) {
        area += sky.faces[face] && !box.periodic[face / 2] ? box.faceArea(face / 2) : 0.0;
        cumulative.push_back(area);
    }
    return {kPi * sky.radiance * area * h * h, [=](const Sample& s, Packet& packet) {
                double u = s[0];
                const int face = int(pick(cumulative, u)), axis = face / 2;
                placeOnFace(box, face, s[1], s[2], packet);
                const double r = std::sqrt(s[3]), angle = 2 * kPi * s[4];  // cosine-distributed: even on the unit disk
                packet.direction[axis] = (face % 2 ? -1 : 1) * std::sqrt(std::max(0.0, 1 - r * r));
                packet.direction[(axis + 1) % 3] = r * std::cos(angle);
                packet.direction[(axis + 2) % 3] = r * std::sin(angle);
            }};
}

/// A rectangle [x0,x1] x [y0,y1] at distance `-z` < 0 from the origin, sampled evenly in solid angle (Urena, Fajardo,
/// King 2013, "An Area-Preserving Parametrization for Spherical Rectangles"). Names as there.
struct SphericalRectangle {
    double x0, x1, y0, y1, z;
    double b0 = 0, b1 = 0, k = 0, solidAngle = 0;

    SphericalRectangle(double x0_, double x1_, double y0_, double y1_, double distance)
        : x0(x0_), x1(x1_), y0(y0_), y1(y1_), z(-distance) {
        const Vec3 v00(x0, y0, z), v01(x0, y1, z), v10(x1, y0, z), v11(x1, y1, z);
        const Vec3 n0 = v00.cross(v10).normalized(), n1 = v10.cross(v11).normalized();
        const Vec3 n2 = v11.cross(v01).normalized(), n3 = v01.cross(v00).normalized();
        const auto angle = [](const Vec3& a, const Vec3& b) {
            return std::acos(std::min(1.0, std::max(-1.0, -a.dot(b))));
        };
        b0 = n0.z;
        b1 = n2.z;
        k = 2 * kPi - angle(n2, n3) - angle(n3, n0);
        solidAngle = std::max(0.0, angle(n0, n1) + angle(n1, n2) - k);
    }

    void point(double u, double v, double& x, double& y) const {
        const double au = u * solidAngle + k, fu = (std::cos(au) * b0 - b1) / std::sin(au);
        const double cu = std::copysign(std::min(1.0, 1 / std::sqrt(fu * fu + b0 * b0)), fu);
        x = std::min(x1, std::max(x0, -cu * z / std::max(std::sqrt(1 - cu * cu), 1e-12)));
        const double d2 = x * x + z * z, h0 = y0 / std::sqrt(d2 + y0 * y0), h1 = y1 / std::sqrt(d2 + y1 * y1);
        const double hv = h0 + v * (h1 - h0);
        y = std::min(y1, std::max(y0, hv * std::sqrt(d2 / std::max(1 - hv * hv, 1e-12))));
    }
};

/// A light outside: packets start on the faces it sees, with the power that flies towards them.
Emitter outerPointEmitter(const Vec3& light, double power, const Box& box) {
    std::vector<double> cumulative;
    std::vector<int> faces;
    std::vector<SphericalRectangle> rectangles;
    double solidAngle = 0;
    for (int face = 0; face < 6; ++face) {
        const int axis = face / 2, b = (axis + 1) % 3, c = (axis + 2) % 3;
        const double distance = face % 2 ? light[axis] - box.size[axis] : -light[axis];
        if (!(distance > 0)) continue;
        rectangles.emplace_back(-light[b], box.size[b] - light[b], -light[c], box.size[c] - light[c], distance);
        faces.push_back(face);
        cumulative.push_back(solidAngle += rectangles.back().solidAngle);
    }
    return {power * solidAngle / (4 * kPi), [=](const Sample& s, Packet& packet) {
                double u = s[0], x = 0, y = 0;
                const std::size_t n = pick(cumulative, u);
                const int axis = faces[n] / 2, b = (axis + 1) % 3, c = (axis + 2) % 3;
                rectangles[n].point(s[1], s[2], x, y);
                placeOnFace(box, faces[n], (x + light[b]) / box.size[b], (y + light[c]) / box.size[c], packet);
                Vec3 d(packet.position[0] - light[0], packet.position[1] - light[1], packet.position[2] - light[2]);
                d.normalize();
                for (int a = 0; a < 3; ++a) packet.direction[a] = d[a];
            }};
}

Emitter innerPointEmitter(const Vec3& light, double power, const Box& box) {
    return {power, [=](const Sample& s, Packet& packet) {
                for (int a = 0; a < 3; ++a) packet.position[a] = light[a];
                isotropicDirection(s[0], s[1], packet.direction);
                locate(box, packet);
            }};
}

Emitter pointEmitter(const McPointLight& light, const McScene& scene, const Box& box) {
    const Vec3 position = (light.position - scene.origin) / scene.h;
    bool inside = true;
    for (int a = 0; a < 3; ++a) inside = inside && position[a] >= 0 && position[a] <= box.size[a];
    if (inside) return innerPointEmitter(position, light.power, box);
    if (scene.periodicX || scene.periodicY)
        throw std::invalid_argument("monteCarlo: a point light outside a periodic box is not supported");
    return outerPointEmitter(position, light.power, box);
}

Emitter emissionEmitter(const McScene& scene, const Box& box) {
    std::vector<double> cumulative(scene.emission.size());
    double sum = 0;
    for (std::size_t n = 0; n < cumulative.size(); ++n) cumulative[n] = sum += scene.emission[n];
    return {sum * scene.h * scene.h * scene.h, [=](const Sample& s, Packet& packet) {
                double u = s[0];
                const int voxel = int(pick(cumulative, u)), ny = box.size[1], nz = box.size[2];
                packet.cell[0] = voxel / (ny * nz);
                packet.cell[1] = voxel / nz % ny;
                packet.cell[2] = voxel % nz;
                for (int a = 0; a < 3; ++a) packet.position[a] = packet.cell[a] + s[1 + a];
                isotropicDirection(s[4], s[5], packet.direction);
            }};
}

std::vector<Emitter> makeEmitters(const McScene& scene, const Box& box) {
    std::vector<Emitter> emitters;
    if (scene.sun) emitters.push_back(sunEmitter(*scene.sun, box, scene.h));
    if (scene.sky) emitters.push_back(skyEmitter(*scene.sky, box, scene.h));
    for (const McPointLight& light : scene.pointLights) emitters.push_back(pointEmitter(light, scene, box));
    if (!scene.emission.empty()) emitters.push_back(emissionEmitter(scene, box));
    const auto dark = [](const Emitter& e) { return !(e.power > 0); };
    emitters.erase(std::remove_if(emitters.begin(), emitters.end(), dark), emitters.end());
    if (emitters.empty()) throw std::invalid_argument("monteCarlo: no light reaches the box");
    return emitters;
}

// ------------------------------------------------------------------------------------------------------- transport

constexpr int kCollided = -1;

/// Flies `depth` optical depths or to the box's boundary, tallying track lengths.
/// @return the face through which the packet escaped, or kCollided with the packet at the collision
int fly(const Box& box, std::vector<Cell>& cells, Packet& packet, double depth) {
    double next[3], delta[3];  // flight lengths at the next wall across each axis, and between two such walls
    int step[3];
    std::ptrdiff_t index = 0;
    for (int a = 0; a < 3; ++a) {
        const double d = packet.direction[a], inside = packet.position[a] - packet.cell[a];
        step[a] = d > 0 ? 1 : -1;
        delta[a] = d != 0 ? 1 / std::abs(d) : 1e300;
        next[a] = d != 0 ? (d > 0 ? 1 - inside : inside) * delta[a] : 1e300;
        index += packet.cell[a] * box.stride[a];
    }
    double flown = 0;
    while (true) {
        const int axis = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
        Cell& cell = cells[std::size_t(index)];
        const double length = std::max(0.0, next[axis] - flown), tau = double(cell.tau) * length;
        if (tau > depth) {
            const double last = depth / double(cell.tau);
            cell.path += packet.power * last;
            for (int a = 0; a < 3; ++a) {
                const double p = packet.position[a] + packet.direction[a] * (flown + last);
                packet.position[a] = std::min(std::max(p, double(packet.cell[a])), packet.cell[a] + 1.0);
            }
            return kCollided;
        }
        cell.path += packet.power * length;
        depth -= tau;
        flown = next[axis];
        next[axis] += delta[axis];
        int moved = packet.cell[axis] + step[axis];
        if (moved < 0 || moved >= box.size[axis]) {
            if (!box.periodic[axis]) return 2 * axis + (step[axis] > 0 ? 1 : 0);
            moved -= step[axis] * box.size[axis];
            packet.position[axis] -= step[axis] * box.size[axis];
        }
        index += (moved - packet.cell[axis]) * box.stride[axis];
        packet.cell[axis] = moved;
    }
}

/// A direction uniform on the sphere without trigonometry (Marsaglia 1972).
void scatter(Random& random, double* direction) {
    double x, y, s;
    do {
        const std::uint64_t bits = random.bits();
        x = double(bits >> 32) * 0x1p-31 - 1;
        y = double(bits & 0xffffffffu) * 0x1p-31 - 1;
        s = x * x + y * y;
    } while (s >= 1);
    const double r = 2 * std::sqrt(1 - s);
    direction[0] = x * r;
    direction[1] = y * r;
    direction[2] = 1 - 2 * s;
}

void scatter(Random& random, double g, double* direction) {
    if (g == 0) return scatter(random, direction);
    const double cosine = henyeyGreensteinCosine(g, random.uniform());
    deflect(cosine, 2 * kPi * random.uniform(), direction);
}

/// Follows a packet to its end. As long as it is strong, collisions take away the absorbed part of its power; then it
/// is absorbed whole or not at all. Both ways all power is accounted for, unlike with Russian roulette.
void follow(const Box& box, double g, std::vector<Cell>& cells, Packet& packet, double depth, Random& random,
            Totals& totals) {
    const double weak = 0.25 * packet.power;
    totals.injected += packet.power;
    for (bool uncollided = true;; uncollided = false) {
        const int face = fly(box, cells, packet, depth);
        if (face != kCollided) {
            totals.escaped[face] += packet.power;
            if (uncollided) totals.uncollided[face] += packet.power;
            return;
        }
        const std::ptrdiff_t index =
            packet.cell[0] * box.stride[0] + packet.cell[1] * box.stride[1] + packet.cell[2] * box.stride[2];
        const double albedo = double(cells[std::size_t(index)].albedo), kept = packet.power * albedo;
        if (kept >= weak) {
            totals.absorbed += packet.power - kept;
            packet.power = kept;
        } else if (random.uniform() >= albedo) {
            totals.absorbed += packet.power;
            return;
        }
        scatter(random, g, packet.direction);
        depth = -std::log(random.uniform());
    }
}

std::uint64_t packetCount(const Emitter& emitter, double allPower, std::uint64_t perBatch) {
    return std::max<std::uint64_t>(1, std::uint64_t(std::llround(double(perBatch) * emitter.power / allPower)));
}

struct Batch {
    std::vector<Cell> cells;
    Totals totals;
    std::uint64_t histories = 0;
};

void runBatch(const Box& box, double g, const std::vector<Emitter>& emitters, bool evenLight, std::uint64_t perBatch,
              Random random, Batch& batch) {
    double allPower = 0;
    for (const Emitter& emitter : emitters) allPower += emitter.power;
    for (const Emitter& emitter : emitters) {
        SpreadPoints points(random, evenLight);
        const std::uint64_t count = packetCount(emitter, allPower, perBatch);
        batch.histories += count;
        for (std::uint64_t n = 0; n < count; ++n) {
            Packet packet;
            const Sample& sample = points.next();
            emitter.start(sample, packet);
            packet.power = emitter.power / double(count);
            follow(box, g, batch.cells, packet, -std::log(std::max(1 - sample[6], 1e-300)), random, batch.totals);
        }
    }
}

// ---------------------------------------------------------------------------------------------------------- result

/// Mean and standard error of values added one per batch, in order.
struct Statistic {
    double sum = 0, squares = 0;

    void add(double x) {
        sum += x;
        squares += x * x;
    }
    McTotal total() const {
        const double mean = sum / kBatches, variance = std::max(0.0, squares / kBatches - mean * mean);
        return {mean, std::sqrt(variance / (kBatches - 1))};
    }
};

struct Statistics {
    std::vector<Statistic> path;
    Statistic injected, absorbed, escaped;
    std::array<Statistic, 6> face, uncollided;

    void add(const Batch& batch) {
        const Totals& t = batch.totals;
        for (std::size_t n = 0; n < path.size(); ++n) path[n].add(batch.cells[n].path);
        injected.add(t.injected);
        absorbed.add(t.absorbed);
        double sum = 0;
        for (int f = 0; f < 6; ++f) {
            face[f].add(t.escaped[f]);
            uncollided[f].add(t.uncollided[f]);
            sum += t.escaped[f];
        }
        escaped.add(sum);
    }
};

void requireAll(const std::vector<double>& values, double largest, const char* what) {
    for (double v : values)
        if (!(v >= 0 && v <= largest))
            throw std::invalid_argument(std::string("monteCarlo: value out of range: ") + what);
}

void validate(const McScene& scene) {
    if (scene.nx < 1 || scene.ny < 1 || scene.nz < 1 || !(scene.h > 0))
        throw std::invalid_argument("monteCarlo: sizes and h must be positive");
    const std::size_t count = std::size_t(scene.nx) * std::size_t(scene.ny) * std::size_t(scene.nz);
    if (scene.extinction.size() != count || (scene.albedo.size() != 1 && scene.albedo.size() != count) ||
        (!scene.emission.empty() && scene.emission.size() != count))
        throw std::invalid_argument("monteCarlo: an array's length is not the number of voxels");
    requireAll(scene.extinction, 1e30, "extinction");
    requireAll(scene.albedo, 1, "albedo");
    requireAll(scene.emission, 1e300, "emission");
    if (!(std::abs(scene.g) < 1)) throw std::invalid_argument("monteCarlo: g must be in (-1,1)");
}

std::vector<Cell> makeCells(const McScene& scene) {
    std::vector<Cell> cells(scene.extinction.size());
    for (std::size_t n = 0; n < cells.size(); ++n) {
        cells[n].tau = float(scene.extinction[n] * scene.h);
        cells[n].albedo = float(scene.albedo[scene.albedo.size() == 1 ? 0 : n]);
    }
    return cells;
}

McResult makeResult(const McScene& scene, const Statistics& statistics) {
    McResult result;
    for (std::size_t n = 0; n < statistics.path.size(); ++n) {
        const McTotal path = statistics.path[n].total();
        const double perPath = 1 / (scene.h * scene.h);  // track length in voxels times h, over the voxel's volume
        const double phi = path.value * perPath, error = path.error * perPath, sigmaT = scene.extinction[n];
        const double albedo = scene.albedo[scene.albedo.size() == 1 ? 0 : n];
        const double emitted = !scene.emission.empty() && sigmaT > 0 ? scene.emission[n] / sigmaT : 0.0;
        result.fluence.push_back(phi);
        result.fluenceError.push_back(error);
        result.collided.push_back(sigmaT * phi);
        result.sourceRadiance.push_back((albedo * phi + emitted) / (4 * kPi));
        result.sourceRadianceError.push_back(albedo * error / (4 * kPi));
    }
    result.injected = statistics.injected.total();
    result.absorbed = statistics.absorbed.total();
    result.escaped = statistics.escaped.total();
    for (int f = 0; f < 6; ++f) {
        result.escapedPerFace[f] = statistics.face[f].total();
        result.escapedUncollidedPerFace[f] = statistics.uncollided[f].total();
    }
    return result;
}

}  // namespace

McResult monteCarlo(const McScene& scene, std::uint64_t histories, std::uint64_t seed) {
    validate(scene);
    const Box box = {{scene.nx, scene.ny, scene.nz},
                     {std::ptrdiff_t(scene.ny) * scene.nz, scene.nz, 1},
                     {scene.periodicX, scene.periodicY, false}};
    const std::vector<Emitter> emitters = makeEmitters(scene, box);
    const std::vector<Cell> blank = makeCells(scene);
    const std::uint64_t perBatch = std::max<std::uint64_t>(1, (histories + kBatches - 1) / kBatches);
    Random seeds(seed);
    Statistics statistics;
    statistics.path.resize(blank.size());
    std::uint64_t followed = 0;
    for (int first = 0; first < kBatches; first += kBatchesAtOnce) {
        std::array<Batch, kBatchesAtOnce> batches;
        std::array<std::uint64_t, kBatchesAtOnce> batchSeeds;
        for (std::uint64_t& s : batchSeeds) s = seeds.bits();
        parallelFor(kBatchesAtOnce, [&](std::size_t b) {
            batches[b].cells = blank;
            runBatch(box, scene.g, emitters, scene.evenLight, perBatch, Random(batchSeeds[b]), batches[b]);
        });
        for (const Batch& batch : batches) {
            statistics.add(batch);
            followed += batch.histories;
        }
    }
    McResult result = makeResult(scene, statistics);
    result.histories = followed;
    return result;
}

}  // namespace raysweep::test
