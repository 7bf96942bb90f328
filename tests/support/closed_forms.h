/// Numbers and formulas the solver is checked against. Nothing here uses the library's solver.
///
/// Slabs are plane-parallel, homogeneous, with isotropic scattering and vacuum on both sides. Depths are optical depths
/// from the face that is lit.
#pragma once

#include <vector>

namespace raysweep::test {

/// Parts of the incident flux that a slab sends back and lets through.
struct SlabReference {
    double opticalThickness;
    double albedo;
    double reflectance;
    double transmittance;
};

/// Diffuse (isotropic) incidence on one face; the transmittance includes the light that never collided. From an
/// integral-equation solution accurate to 2e-4, which agrees with Modest, Radiative Heat Transfer, table 14.1.
constexpr SlabReference kDiffuseSlabs[] = {
    {0.5, 1.0, .2958, .7042}, {0.5, 0.9, .2475, .6599}, {0.5, 0.5, .1077, .5350}, {1.0, 1.0, .4466, .5534},
    {1.0, 0.9, .3527, .4748}, {1.0, 0.5, .1342, .3067}, {2.0, 1.0, .6099, .3901}, {2.0, 0.9, .4372, .2656},
    {2.0, 0.5, .1451, .1071}, {5.0, 1.0, .7923, .2077}, {5.0, 0.9, .4763, .0534}, {5.0, 0.5, .1465, .0053},
};
constexpr double kDiffuseSlabTolerance = 2.5e-4;  ///< 2e-4 of the source and half a unit of the last digit

/// Parallel beam whose direction makes the cosine `kBeamCosine` with the slab's normal; the transmittance is the
/// scattered part alone. DISORT test cases 1a to 1f (16 streams) as stored with PythonicDISORT.
constexpr double kBeamCosine = 0.1;
constexpr SlabReference kBeamSlabs[] = {
    {0.03125, 0.2, .025447, .025277}, {0.03125, 1.0, .134651, .133782}, {0.03125, 0.99, .133177, .132330},
    {32.0, 0.2, .082661, 0.0},        {32.0, 1.0, .978426, .021536},    {32.0, 0.99, .877511, .000779},
};
constexpr double kBeamSlabTolerance = 1e-3;  ///< 16 streams do not resolve more

/// Chandrasekhar's H(mu) for isotropic scattering. A semi-infinite medium reflects 1 - sqrt(1 - albedo) H(mu0) of a
/// beam of cosine mu0 (Chandrasekhar, Radiative Transfer, chapter V).
struct ChandrasekharH {
    double albedo;
    double cosine;
    double value;
};
constexpr ChandrasekharH kChandrasekharH[] = {
    {0.5, 0.1, 1.0724},  {0.5, 0.5, 1.1877}, {0.5, 1.0, 1.2513},  {0.9, 0.1, 1.1721},
    {0.9, 0.5, 1.5560},  {0.9, 1.0, 1.8501}, {0.99, 0.1, 1.2249}, {0.99, 0.5, 1.8486},
    {0.99, 1.0, 2.4728}, {1.0, 0.1, 1.2474}, {1.0, 0.5, 2.0128},  {1.0, 1.0, 2.9078},
};

/// Exponential integral E_n(x) = int_1^inf exp(-x t) / t^n dt for n = 1, 2, 3 and x >= 0 (E_1(0) is infinite), to about
/// 1e-14 absolute. Abramowitz & Stegun 5.1.11 (series), 5.1.22 (continued fraction), 5.1.14 (recurrence).
double exponentialIntegral(int n, double x);

/// Gauss-Legendre rule on [0, 1].
struct Quadrature {
    std::vector<double> points;
    std::vector<double> weights;
};
Quadrature gaussLegendre(int count);

/// p(tau) = mean over all directions of (1 - exp(-tau l)) / (tau l), with l = 1 / max|omega_i| the length of a sweep's
/// step through a slice one unit thick: the probability that power emitted evenly along the steps through a voxel
/// leaves it without colliding there. `opticalDepth` is extinction times voxel size. Accurate to 1e-12.
double escapeProbability(double opticalDepth);

/// Light on the slab's face at depth 0.
enum class SlabLight {
    Diffuse,  ///< radiance 1 from every direction: incident flux pi
    Beam,     ///< irradiance 1 at normal incidence: incident flux = its cosine
};

/// A solved slab: source radiances of thin layers, and the fluxes relative to the incident one.
struct SlabSolution {
    double opticalThickness = 0;
    double albedo = 0;
    SlabLight light = SlabLight::Diffuse;
    double beamCosine = 1;
    std::vector<double> edges;           ///< depths between which the layers lie, ascending, from 0 to the thickness
    std::vector<double> layers;          ///< mean source radiance of each layer [1/sr per unit of the light]
    double reflectance = 0;              ///< scattered back
    double transmittance = 0;            ///< scattered through
    double uncollidedTransmittance = 0;  ///< let through without any collision
};

/// Solves S(t) = albedo (S0(t) + 1/2 int S(t') E1|t - t'| dt') by collision probabilities (Galerkin's method with
/// constant layers, thin at both faces) and extrapolates the fluxes from `layerCount / 2` and `layerCount` layers
/// (Richardson). With the default number of layers fluxes are accurate to
/// about 1e-5 and layers' source radiances to 1e-4 of themselves. `beamCosine` in (0, 1] is used by
/// a beam only.
SlabSolution solveSlab(double opticalThickness, double albedo, SlabLight light, double beamCosine = 1,
                       int layerCount = 400);

/// Mean source radiance S = albedo fluence / (4 pi) between two depths `from` < `to`, by inserting the layers once more
/// into the integral equation. Unit: that of a radiance for light of radiance 1 (diffuse) or irradiance 1 (beam).
double meanSourceRadiance(const SlabSolution& slab, double from, double to);

}  // namespace raysweep::test
