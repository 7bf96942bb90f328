#include "raysweep/reconstruct/photo_light.h"

#include "raysweep/core/directions.h"
#include "raysweep/core/require.h"
#include "raysweep/reconstruct/photo_colors.h"
#include "raysweep/reconstruct/photo_sart.h"
#include "raysweep/reconstruct/photo_sheets.h"
#include "raysweep/reconstruct/photo_sightings.h"
#include "raysweep/reconstruct/photo_surfaces.h"
#include "raysweep/reconstruct/photo_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

namespace raysweep {
namespace {

/// The first volume's: the guess at the light is no better in finer ones, and steps are cheap there.
constexpr int kFirstResolution = 64;
/// The opposite light leaves more by this part if it is surely wrong.
constexpr double kSure = 0.1;

/// Evenly, `most` of them; the first always.
std::vector<Photograph> someOf(const std::vector<Photograph>& photographs, int most) {
    const std::size_t count = std::min(photographs.size(), std::size_t(most));
    std::vector<Photograph> some;
    for (std::size_t i = 0; i < count; ++i) some.push_back(photographs[i * photographs.size() / count]);
    return some;
}

ReconstructionGrid coarser(ReconstructionGrid grid, int resolution) {
    const Vec3 size = grid.size();
    grid.spacing = Vec3(std::max(grid.edge(), std::max({size.x, size.y, size.z}) / resolution));
    for (int axis = 0; axis < 3; ++axis) grid.dims[axis] = std::max(1, int(std::ceil(size[axis] / grid.edge() - 1e-6)));
    return grid;
}

float sumOf(const std::array<float, 3>& color) {
    return color[0] + color[1] + color[2];
}

/// Two directions across the light's and each other.
struct Beside {
    Vec3 u, v;

    explicit Beside(const Vec3& light) {
        u = light.cross(axisAside(light)).normalized();
        v = light.cross(u);
    }
};

/// A light, the colours that suit it, and what of its changes colours absorb; unknowns are its turns to two sides, and
/// the diffuse part.
struct Trial {
    LightState state;
    std::vector<CompositeVoxel> colors, absorbed;
    Matrix3 matrix = Matrix3(0, 0, 0, 0, 0, 0, 0, 0, 0);  ///< products of slopes, without what colours could do, summed
    Vec3 right{0};                                        ///< those with what is left
    double left = 0, power = 0;                           ///< squares of what is left, and of the pictures
};

/// What small changes of the unknowns do to the brightness of a view, in place of colours.
void setSlopes(const ColorSolver& solver, const Trial& trial, std::size_t view, std::vector<CompositeVoxel>& slopes) {
    const SheetLight light = solver.light(trial.state, view);
    const Beside beside(trial.state.light);
    const Vec3 u = carriedAlong(beside.u, solver.camera(0), solver.camera(view));
    const Vec3 v = carriedAlong(beside.v, solver.camera(0), solver.camera(view));
    solver.forVoxels([&](std::size_t i) {
        const SheetNormal& n = solver.sheets().normals[i];
        const SheetBrightness bright(n, light);
        const CompositeVoxel& color = trial.colors[i];
        const float c = color.red + color.green + color.blue, along = -c * bright.along;  // light travels, -toLight
        const Vec3 axis(n.axis[0], n.axis[1], n.axis[2]);
        slopes[i] = {color.extinction, along * float(axis.dot(u)), along * float(axis.dot(v)), c * bright.diffuse};
    });
}

/// Colours for the trial's light, and what is left then.
void solve(ColorSolver& solver, int passes, Trial& trial) {
    const std::size_t views = solver.views();
    std::vector<RayPixels> targets(views), slopes(views);
    for (std::size_t n = 0; n < views; ++n)
        for (const auto& pixel : solver.rays(n).pixels) targets[n].push_back({pixel[0], pixel[1], pixel[2]});
    solver.solve(targets, trial.state, passes, trial.colors);
    std::vector<CompositeVoxel> changes(trial.colors.size());
    for (std::size_t n = 0; n < views; ++n) {
        setSlopes(solver, trial, n, changes);
        slopes[n] = solver.seen(changes, n);
    }
    solver.solve(slopes, trial.state, passes, trial.absorbed);
    trial.matrix = Matrix3(0, 0, 0, 0, 0, 0, 0, 0, 0);
    trial.right = Vec3(0);
    trial.left = trial.power = 0;
    for (std::size_t n = 0; n < views; ++n) {
        const SheetLight light = solver.light(trial.state, n);
        const RayPixels seen = solver.seen(trial.colors, light, n), gone = solver.seen(trial.absorbed, light, n);
        for (std::size_t r = 0; r < seen.size(); ++r) {
            const double all = sumOf(targets[n][r]), left = all - sumOf(seen[r]);
            Vec3 slope;
            for (int i = 0; i < 3; ++i) slope[i] = slopes[n][r][std::size_t(i)] - gone[r][std::size_t(i)];
            trial.power += all * all;
            trial.left += left * left;
            trial.right += slope * left;
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j) trial.matrix[i][j] += slope[i] * slope[j];
        }
    }
}

/// Of the trial's matrix. Where nothing depends on an unknown it is near to 0 from there on.
Matrix3 inverseOf(const Trial& trial) {
    Matrix3 matrix = trial.matrix;
    const double trace = matrix[0][0] + matrix[1][1] + matrix[2][2];
    for (int i = 0; i < 3; ++i) matrix[i][i] += 1e-6 * trace + 1e-30;
    return matrix.gjInverse();
}

/// Changes the light by what the equations say, and colours such that ambient and diffuse light together are 1.
void step(Trial& trial) {
    constexpr double kMostTurn = 0.5;       // radians
    constexpr double kLeastAmbient = 1e-3;  // of all: without it there is no scale to colours that see no light
    constexpr double kMostLoss = 0.75;      // of diffuse light: without it nothing leads back
    LightState& state = trial.state;
    const Vec3 change = trial.right * inverseOf(trial);
    const double turn = std::hypot(change.x, change.y), part = turn > kMostTurn ? kMostTurn / turn : 1;
    const Beside beside(state.light);
    const Vec3 light = (state.light + (beside.u * change.x + beside.v * change.y) * part).normalized();
    const double ambient = std::max(state.ambient, kLeastAmbient);
    const double diffuse = std::max((1 - kMostLoss) * state.diffuse, state.diffuse + change.z), all = ambient + diffuse;
    if (!std::isfinite(all)) return;
    state = {light, ambient / all, diffuse / all};
    for (CompositeVoxel& color : trial.colors) {
        color.red *= float(all);
        color.green *= float(all);
        color.blue *= float(all);
    }
}

/// What is left more, at least, by a light that is one radian aside, were it so far linear; its diffuse part suits it.
double leastTold(const Trial& trial) {
    const Matrix3 inverse = inverseOf(trial);
    const double sum = inverse[0][0] + inverse[1][1], difference = inverse[0][0] - inverse[1][1];
    return 2 / (sum + std::hypot(difference, 2 * inverse[0][1]));
}

/// A volume of some resolution, as what light falls on.
struct LightLevel {
    std::vector<Photograph> pictures, lit;  ///< of the volume; of these, those for the colours
    PhotoSurfaces surfaces;
    LitSheets sheets;
};

/// Nothing if it was stopped.
std::unique_ptr<LightLevel> lightLevel(const std::vector<Photograph>& photographs, const ReconstructionGrid& grid,
                                       const PhotoLightOptions& options, const ProgressCallback& progress) {
    auto level = std::make_unique<LightLevel>();
    level->pictures = picturesFor(someOf(photographs, options.views), grid);
    level->lit = someOf(level->pictures, options.lit);
    PhotoSartOptions first;
    first.iterations = options.passes;
    const PhotoReconstruction volume = photoSart(level->pictures, grid, first, {}, progress);
    if (volume.termination == PhotoTermination::interrupted) return nullptr;
    level->surfaces = surfacesOf(volume, grid);
    level->sheets = litSheets(level->surfaces);
    return level;
}

/// Looks for a light, step after step.
class LightSearch {
  public:
    /// @param steps all that there will be, for `progress`
    LightSearch(const PhotoLightOptions& options, int steps, ProgressCallback progress)
        : options_(options), all_(steps), progress_(std::move(progress)) {}

    /// For the trial's light, from black. @return false if it was stopped
    bool start(ColorSolver& solver, Trial& trial) {
        trial.colors = trial.absorbed = solver.black();
        return solved(solver, trial);
    }

    bool take(ColorSolver& solver, int steps, Trial& trial) {
        for (int n = 0; n < steps; ++n) {
            step(trial);
            if (!solved(solver, trial)) return false;
        }
        return true;
    }

    ProgressCallback volume() const {
        return [this](const std::string&, double) { return tell(); };
    }

  private:
    bool solved(ColorSolver& solver, Trial& trial) {
        if (!tell()) return false;
        solve(solver, options_.colorPasses, trial);
        ++done_;
        return true;
    }

    bool tell() const { return report(progress_, "looking for the light", double(done_) / all_); }

    const PhotoLightOptions& options_;
    int all_, done_ = 0;
    ProgressCallback progress_;
};

constexpr int kTrialSteps = 2;  ///< after which two guesses are compared

/// What is said of a light, from how its neighbours fare. @param opposite squares that the other guess leaves, in those
/// that this one does
PhotoLight judged(const Trial& trial, double opposite) {
    const LightState& state = trial.state;
    const double told = leastTold(trial), aside = 2 * std::sin(15 * kPi / 180);
    const double all = state.diffuse * state.diffuse * trial.matrix[2][2];
    const double power = std::max(trial.power, 1e-30), left = std::max(trial.left, 1e-30);
    PhotoLight light;
    light.shading.light = state.light;
    light.shading.diffuse = state.diffuse;
    light.shading.ambient = 1 - light.shading.diffuse;
    light.residual = std::sqrt(trial.left / power);
    light.aside = std::sqrt((trial.left + told * aside * aside) / power);
    light.ambient = std::sqrt((trial.left + all) / power);
    const double known = told / (left + told), sure = std::clamp((opposite - 1) / kSure, 0.0, 1.0);
    light.confidence = known * sure;
    return light;
}

}  // namespace

void PhotoLightOptions::validate() const {
    requireField(resolution >= 8 && resolution <= 256, "resolution of the light's volume", resolution, "from 8 to 256");
    requireField(views > 1, "views for the light", views, "at least 2");
    requireField(lit > 1, "views for colours in the light", lit, "at least 2");
    requireField(passes > 0, "passes for the light", passes, "at least 1");
    requireField(places > 0, "places for the light", places, "at least 1");
    requireField(directions > 1, "directions of the light", directions, "at least 2");
    requireField(steps >= 0, "steps for the light", steps, "at least 0");
    requireField(fineSteps >= 0, "steps for the light in the finer volume", fineSteps, "at least 0");
    requireField(colorPasses > 0, "passes for colours in the light", colorPasses, "at least 1");
}

std::optional<PhotoLight> findLight(const std::vector<Photograph>& photographs, const ReconstructionGrid& grid,
                                    const PhotoLightOptions& options, const ProgressCallback& progress) {
    options.validate();
    const ReconstructionGrid fine = coarser(grid, options.resolution), first = coarser(fine, kFirstResolution);
    const bool twice = first.resolution() < fine.resolution();
    LightSearch search(options, 2 * (kTrialSteps + 1) + options.steps + (twice ? 1 + options.fineSteps : 0), progress);
    Trial best;
    double opposite = 1;
    {
        const auto level = lightLevel(photographs, first, options, search.volume());
        if (!level) return {};
        const Vec3 guess =
            guessLight(level->pictures, level->surfaces, std::size_t(options.places), options.directions).light;
        ColorSolver solver(level->lit, level->sheets);
        Trial other;
        best.state.light = guess.normalized();
        other.state.light = best.state.light * -1.0;
        // Sheets of which both sides are seen look nearly the same in the opposite light.
        for (Trial* trial : {&best, &other})
            if (!search.start(solver, *trial) || !search.take(solver, kTrialSteps, *trial)) return {};
        if (other.left < best.left) std::swap(best, other);
        opposite = other.left / std::max(best.left, 1e-30);
        if (!search.take(solver, options.steps, best)) return {};
    }
    if (twice) {
        const auto level = lightLevel(photographs, fine, options, search.volume());
        if (!level) return {};
        ColorSolver solver(level->lit, level->sheets);
        if (!search.start(solver, best) || !search.take(solver, options.fineSteps, best)) return {};
    }
    return judged(best, opposite);
}

}  // namespace raysweep
