#include "raysweep/render/photo_quality.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/core/require.h"
#include "raysweep/image/compare.h"
#include "raysweep/image/image_io.h"
#include "raysweep/image/matte_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace raysweep {
namespace {

// From residuals of real and of generated sets: see viewsStandingOut in the tests.
constexpr std::size_t kFewestToCompare = 5;
constexpr double kDeviations = 5, kPerMad = 1.4826;  // the latter makes a normal distribution's MAD its sigma
constexpr double kLeastRatio = 1.5;

constexpr float kDifferenceScale = 2;

void requireSize(const Photograph& photograph) {
    const Image& matte = photograph.matte;
    if (matte.width != photograph.camera.width || matte.height != photograph.camera.height || matte.channels != 4)
        throw InvalidArgument("photograph '" + photograph.name + "' has " + std::to_string(matte.width) + " x " +
                              std::to_string(matte.height) + " pixels and " + std::to_string(matte.channels) +
                              " channels; its camera's " + std::to_string(photograph.camera.width) + " x " +
                              std::to_string(photograph.camera.height) + " and 4 are needed");
}

/// The volume as one camera after another sees it. Where light comes from a lamp beside the camera, its colours differ
/// from view to view.
class LitColors {
  public:
    LitColors(const ColorVolume& volume, const PhotoQualityOptions& options)
        : options_(options), input_{volume.density, 1, volume.color}, color_(volume.color), ready_(input_) {
        const Shading& shading = options.shading;
        if (!(shading.diffuse > 0) && shading.ambient == 1) return;
        normals_ = surfaceNormals(*volume.density, 1, *volume.color);
        if (!goesAlong()) show(shading);
    }

    const RenderVolume& asSeenBy(const PhotoCamera& camera) {
        if (options_.colors) {
            input_.radiosity = options_.colors(camera);
            ready_ = RenderVolume(input_);
        }
        if (!goesAlong()) return ready_;
        Shading shading = options_.shading;
        shading.light = carriedAlong(shading.light, *options_.lampBeside, camera);
        show(shading);
        return ready_;
    }

  private:
    bool goesAlong() const { return options_.lampBeside && options_.shading.diffuse > 0; }

    void show(const Shading& shading) {
        input_.radiosity = shaded(*color_, *normals_, shading);
        ready_ = RenderVolume(input_);
    }

    const PhotoQualityOptions& options_;
    RenderInput input_;
    openvdb::Vec3SGrid::ConstPtr color_;
    openvdb::Vec3SGrid::Ptr normals_;
    RenderVolume ready_;
};

/// @param shown, truth of the same two pictures, as displayed
double residualOf(const Image& shown, const Image& truth, const Image& render, const Image& photograph) {
    double sum = 0;
    std::size_t count = 0;
    for (std::size_t p = 0; p < shown.pixels.size() / 3; ++p) {
        if (!(render.pixels[4 * p + 3] > 0) && !(photograph.pixels[4 * p + 3] > 0)) continue;
        ++count;
        for (std::size_t c = 3 * p; c < 3 * p + 3; ++c) {
            const double difference = double(shown.pixels[c]) - truth.pixels[c];
            sum += difference * difference;
        }
    }
    return count > 0 ? std::sqrt(sum / (3.0 * double(count))) : 0.0;
}

ViewQuality compare(const Photograph& photograph, const Image& render, float backdrop) {
    const Image truth = shownBefore(photograph.matte, backdrop), shown = shownBefore(render, backdrop);
    const ImageDifference difference = compareImages(shown, truth);
    return {photograph.name, difference.psnr, difference.ssim, residualOf(shown, truth, render, photograph.matte)};
}

double medianOf(std::vector<double> values) {
    const std::size_t half = values.size() / 2;
    std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(half), values.end());
    if (values.size() % 2 == 1) return values[half];
    return 0.5 * (values[half] + *std::max_element(values.begin(), values.begin() + std::ptrdiff_t(half)));
}

void takeMeans(PhotoQuality& quality) {
    const double count = double(quality.views.size());
    quality.psnr = quality.ssim = count > 0 ? 0 : std::numeric_limits<double>::quiet_NaN();
    for (const ViewQuality& view : quality.views) quality.psnr += view.psnr / count, quality.ssim += view.ssim / count;
}

}  // namespace

void PhotoQualityOptions::validate() const {
    requireField(backdrop >= 0 && backdrop <= 1, "backdrop", backdrop, "in [0,1]");
    shading.validate();
    if (lampBeside) lampBeside->validate();
    if (colors && (shading.diffuse > 0 || shading.ambient != 1))
        throw InvalidArgument("colors: those that cameras see are lit already; leave out `shading`");
    picture.validate();
}

PhotoQuality judge(const ColorVolume& volume, const std::vector<Photograph>& photographs,
                   const PhotoQualityOptions& options, const SeeRender& see, const ProgressCallback& progress) {
    const Timer timer;
    options.validate();
    for (const Photograph& photograph : photographs) requireSize(photograph);
    LitColors colors(volume, options);
    RenderOptions picture = options.picture;
    picture.background = grey(0);
    PhotoQuality quality;
    const double count = double(photographs.size());
    const auto viewProgress = [&](const std::string&, double fraction) {
        return report(progress, "comparing views", (double(quality.views.size()) + fraction) / count);
    };
    for (std::size_t n = 0; n < photographs.size() && quality.complete; ++n) {
        const PhotoCamera& camera = photographs[n].camera;
        const RenderResult result = render(colors.asSeenBy(camera), camera, picture, viewProgress);
        quality.complete = result.complete;
        if (!result.complete) break;
        quality.views.push_back(compare(photographs[n], result.image, options.backdrop));
        if (see) see(n, result.image);
    }
    takeMeans(quality);
    quality.seconds = timer.seconds();
    return quality;
}

Image comparisonPicture(const Image& photograph, const Image& render, float backdrop) {
    const Image truth = shownBefore(photograph, backdrop), shown = shownBefore(render, backdrop);
    if (truth.width != shown.width || truth.height != shown.height)
        throw InvalidArgument("pictures to be compared must have one size");
    Image picture(3 * truth.width, truth.height, 3);
    for (int y = 0; y < truth.height; ++y)
        for (int x = 0; x < truth.width; ++x)
            for (int c = 0; c < 3; ++c) {
                const float is = shown.at(x, y)[c], should = truth.at(x, y)[c];
                const float difference = 0.5f + kDifferenceScale * (is - should);
                picture.at(x, y)[c] = linearFromSrgb(should);
                picture.at(truth.width + x, y)[c] = linearFromSrgb(is);
                picture.at(2 * truth.width + x, y)[c] = linearFromSrgb(std::clamp(difference, 0.0f, 1.0f));
            }
    return picture;
}

std::vector<std::size_t> viewsStandingOut(const std::vector<ViewQuality>& views) {
    std::vector<std::size_t> worst;
    if (views.size() < kFewestToCompare) return worst;
    // Below the rounding of 8 bits views are alike, however their residuals compare.
    constexpr double kLeast = 0.5 / 255;
    std::vector<double> logs, deviations;
    for (const ViewQuality& view : views) logs.push_back(std::log(std::max(view.residual, kLeast)));
    const double median = medianOf(logs);
    for (const double log : logs) deviations.push_back(std::abs(log - median));
    const double limit = median + std::max(kDeviations * kPerMad * medianOf(deviations), std::log(kLeastRatio));
    for (std::size_t n = 0; n < views.size(); ++n)
        if (logs[n] > limit) worst.push_back(n);
    std::sort(worst.begin(), worst.end(),
              [&](std::size_t a, std::size_t b) { return views[a].residual > views[b].residual; });
    return worst;
}

}  // namespace raysweep
