#include "support/closed_forms.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

#include "raysweep/core/types.h"

namespace raysweep::test {
namespace {

constexpr double kEulerGamma = 0.57721566490153286061;

double firstExponentialIntegral(double x) {
    if (x == 0) return std::numeric_limits<double>::infinity();
    if (x <= 1) {
        double sum = -kEulerGamma - std::log(x), power = 1;
        for (int k = 1; k < 30; ++k) {
            power *= -x / k;
            sum -= power / k;
        }
        return sum;
    }
    if (x > 700) return 0;
    // Continued fraction, evaluated from its tail; the smaller x, the more terms it needs.
    const int terms = 20 + int(120 / x);
    double tail = 0;
    for (int k = terms; k > 0; --k) tail = double(k) * k / (x + 2 * k + 1 - tail);
    return std::exp(-x) / (x + 1 - tail);
}

/// int over a layer [a, b] of 1/2 E2(|t - face|) dt / (b - a), for a face outside the layer: the probability that power
/// emitted evenly in the layer leaves through that face without a collision.
double faceProbability(double face, double a, double b) {
    const double nearest = std::min(std::abs(a - face), std::abs(b - face));
    const double farthest = std::max(std::abs(a - face), std::abs(b - face));
    return 0.5 * (exponentialIntegral(3, nearest) - exponentialIntegral(3, farthest)) / (b - a);
}

/// The function whose second derivative is the kernel 1/2 E1|x|; integrals of the kernel over two intervals are its
/// second differences.
double integratedKernel(double x) {
    return 0.5 * (std::abs(x) - 0.5 + exponentialIntegral(3, std::abs(x)));
}

/// Mean over t in [a, b] of 1/2 int_c^d E1|t - t'| dt'.
double layerCoupling(double a, double b, double c, double d) {
    return (integratedKernel(b - c) - integratedKernel(b - d) - integratedKernel(a - c) + integratedKernel(a - d)) /
           (b - a);
}

/// Mean over [a, b] of the fluence of the light that has not collided, divided by 4 pi.
double uncollidedMean(const SlabSolution& slab, double a, double b) {
    if (slab.light == SlabLight::Diffuse) return faceProbability(0, a, b);
    const double mu = slab.beamCosine;
    return std::exp(-a / mu) * -std::expm1(-(b - a) / mu) * mu / (b - a) / (4 * kPi);
}

/// Layers that become thin at both faces, where the source function has an infinite slope.
std::vector<double> gradedEdges(double thickness, int count) {
    std::vector<double> edges(count + 1);
    for (int i = 0; i <= count; ++i) {
        const double s = std::sin(0.5 * kPi * i / count);
        edges[i] = thickness * s * s;
    }
    edges[count] = thickness;
    return edges;
}

/// Solves A x = b in place by elimination. No pivoting: A is diagonally dominant here.
void solveDense(std::vector<double>& a, std::vector<double>& x) {
    const std::size_t n = x.size();
    for (std::size_t p = 0; p < n; ++p) {
        for (std::size_t r = p + 1; r < n; ++r) {
            const double factor = a[r * n + p] / a[p * n + p];
            for (std::size_t c = p + 1; c < n; ++c) a[r * n + c] -= factor * a[p * n + c];
            x[r] -= factor * x[p];
        }
    }
    for (std::size_t r = n; r-- > 0;) {
        for (std::size_t c = r + 1; c < n; ++c) x[r] -= a[r * n + c] * x[c];
        x[r] /= a[r * n + r];
    }
}

/// integratedKernel between all pairs of edges, row by row.
std::vector<double> kernelTable(const std::vector<double>& edges) {
    const std::size_t m = edges.size();
    std::vector<double> table(m * m);
    for (std::size_t i = 0; i < m; ++i)
        for (std::size_t j = 0; j <= i; ++j)
            table[i * m + j] = table[j * m + i] = integratedKernel(edges[i] - edges[j]);
    return table;
}

void solveLayers(SlabSolution& slab, int count) {
    slab.edges = gradedEdges(slab.opticalThickness, count);
    const std::size_t n = std::size_t(count), m = n + 1;
    const std::vector<double>& e = slab.edges;
    const std::vector<double> kernel = kernelTable(e);
    std::vector<double> matrix(n * n);
    slab.layers.assign(n, 0);
    for (std::size_t i = 0; i < n; ++i) {
        const double *low = &kernel[i * m], *high = low + m;
        for (std::size_t j = 0; j < n; ++j) {  // layerCoupling of layers i and j
            const double coupling = (high[j] - high[j + 1] - low[j] + low[j + 1]) / (e[i + 1] - e[i]);
            matrix[i * n + j] = (i == j ? 1.0 : 0.0) - slab.albedo * coupling;
        }
        slab.layers[i] = slab.albedo * uncollidedMean(slab, e[i], e[i + 1]);
    }
    solveDense(matrix, slab.layers);
}

double incidentFlux(const SlabSolution& slab) {
    return slab.light == SlabLight::Diffuse ? kPi : slab.beamCosine;
}

/// Flux that the layers send out through a face, relative to the incident one.
double scatteredFlux(const SlabSolution& slab, double face) {
    double flux = 0;
    for (std::size_t i = 0; i < slab.layers.size(); ++i) {
        const double a = slab.edges[i], b = slab.edges[i + 1];
        flux += 4 * kPi * slab.layers[i] * (b - a) * faceProbability(face, a, b);
    }
    return flux / incidentFlux(slab);
}

}  // namespace

double exponentialIntegral(int n, double x) {
    if (n == 1) return firstExponentialIntegral(x);
    if (x == 0) return 1.0 / (n - 1);
    return (std::exp(-x) - x * exponentialIntegral(n - 1, x)) / (n - 1);
}

Quadrature gaussLegendre(int count) {
    Quadrature rule;
    for (int i = 0; i < count; ++i) {
        double x = std::cos(kPi * (i + 0.75) / (count + 0.5)), slope = 1;
        for (int newton = 0; newton < 100; ++newton) {
            double previous = 1, value = x;
            for (int k = 2; k <= count; ++k) {
                const double next = ((2 * k - 1) * x * value - (k - 1) * previous) / k;
                previous = value;
                value = next;
            }
            slope = count * (x * value - previous) / (x * x - 1);
            const double step = value / slope;
            x -= step;
            if (std::abs(step) < 1e-15) break;
        }
        rule.points.push_back(0.5 * (1 - x));
        rule.weights.push_back(1 / ((1 - x * x) * slope * slope));
    }
    return rule;
}

double escapeProbability(double opticalDepth) {
    // The directions through one eighth of a cube's faces, parametrised on a quarter of one face: omega = (u, v, 1) /
    // l.
    const Quadrature rule = gaussLegendre(32);
    double sum = 0;
    for (std::size_t i = 0; i < rule.points.size(); ++i) {
        for (std::size_t j = 0; j < rule.points.size(); ++j) {
            const double u = rule.points[i], v = rule.points[j], length = std::sqrt(1 + u * u + v * v);
            const double tau = opticalDepth * length;
            const double escape = tau > 0 ? -std::expm1(-tau) / tau : 1.0;
            sum += rule.weights[i] * rule.weights[j] * escape / (length * length * length);
        }
    }
    return 24 * sum / (4 * kPi);
}

SlabSolution solveSlab(double opticalThickness, double albedo, SlabLight light, double beamCosine, int layerCount) {
    if (!(opticalThickness > 0) || !(albedo >= 0 && albedo <= 1) || !(beamCosine > 0 && beamCosine <= 1))
        throw std::invalid_argument("solveSlab: thickness must be > 0, albedo in [0,1], beam cosine in (0,1]");
    SlabSolution slab;
    slab.opticalThickness = opticalThickness;
    slab.albedo = albedo;
    slab.light = light;
    slab.beamCosine = beamCosine;
    slab.uncollidedTransmittance = light == SlabLight::Diffuse ? 2 * exponentialIntegral(3, opticalThickness)
                                                               : std::exp(-opticalThickness / beamCosine);
    solveLayers(slab, layerCount / 2);
    const double coarseR = scatteredFlux(slab, 0), coarseT = scatteredFlux(slab, opticalThickness);
    solveLayers(slab, layerCount);
    const double fineR = scatteredFlux(slab, 0), fineT = scatteredFlux(slab, opticalThickness);
    slab.reflectance = fineR + (fineR - coarseR) / 3;  // the error falls with the square of the layers' thickness
    slab.transmittance = fineT + (fineT - coarseT) / 3;
    return slab;
}

double meanSourceRadiance(const SlabSolution& slab, double from, double to) {
    double mean = uncollidedMean(slab, from, to);
    for (std::size_t j = 0; j < slab.layers.size(); ++j)
        mean += slab.layers[j] * layerCoupling(from, to, slab.edges[j], slab.edges[j + 1]);
    return slab.albedo * mean;
}

}  // namespace raysweep::test
