#include "raysweep/reconstruct/photo_level_fit.h"

#include "raysweep/core/brief.h"
#include "raysweep/projector/composite.h"
#include "raysweep/reconstruct/photo_loss.h"
#include "raysweep/reconstruct/voxel_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace raysweep {
namespace {

constexpr int kSmoothEvery = 4;  ///< updates; weighted accordingly
constexpr int kTuneEvery = 8;    ///< updates

double rms(double sumOfSquares, double pixels) {
    return pixels > 0 ? std::sqrt(sumOfSquares / (3 * pixels)) : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

LevelFit::LevelFit(PhotoLevel& level, const PhotoPixels& pixels, const PhotoFitOptions& options, const Timer& timer,
                   PhotoReconstruction& result)
    : level_(level),
      pixels_(pixels),
      options_(options),
      timer_(timer),
      result_(result),
      backdrops_{float(options.backdrop), float(options.backdropSpread)},
      sets_(pixelsMeeting(pixels, level, options)),
      random_(options.seed),
      kept_(level.layout.keptVoxels()) {}

bool LevelFit::run(double passes, Smoothness& smoothness, const ProgressCallback& progress, double from, double to) {
    const Timer timer;
    const auto startPass = [&] { pass_ = passOver(sets_.fitted, std::size_t(options_.raysPerUpdate)); };
    startPass();
    const std::size_t perPass = pass_.pieces.size();
    const int updates = perPass > 0 ? std::max(1, int(std::lround(passes * double(perPass)))) : 0;
    bool goesOn = true;
    for (int n = 0; n < updates && goesOn; ++n) {
        const std::size_t piece = std::size_t(n) % perPass;
        if (n > 0 && piece == 0) startPass();
        update(n, double(n) / updates, piece, smoothness.weight());
        if (options_.adaptSmoothness && n % kTuneEvery == kTuneEvery - 1) tune(smoothness);
        goesOn = report(progress, howItGoes(), from + (to - from) * (n + 1) / updates);
        if (piece == perPass - 1 || n == updates - 1) addPoint();
    }
    result_.timings.updates += timer.seconds();
    return goesOn;
}

PixelPieces LevelFit::passOver(const std::vector<std::uint32_t>& pixels, std::size_t most) {
    return directional() ? shuffledPiecesOfViews(pixels_, pixels, most, random_)
                         : shuffledPieces(pixels, most, random_);
}

/// The volume as a pixel's view sees it.
const CompositeVoxel* LevelFit::shownTo(std::uint32_t pixel) {
    if (!directional()) return level_.voxels.data();
    from_ = viewPoint(pixels_.place(pixel).photograph->camera, level_.grid);
    showVoxels(level_, from_, shown_);
    return shown_.data();
}

/// Adds the derivative of some pixels' loss to the level's.
void LevelFit::differentiate(const PixelPieces& pass, std::size_t piece) {
    const std::uint32_t* chosen = pass.pixels.data() + pass.pieces[piece].first;
    batch_.set(pixels_, chosen, pass.pieces[piece].count, level_, options_.samplesPerSlice);
    compositeGradient(
        level_.layout, shownTo(*chosen), batch_.rays,
        [&](std::size_t at, std::size_t some, const RayColor* colors, RayColor* derivatives) {
            for (std::size_t i = 0; i < some; ++i)
                batch_.errors[at + i] = pixelLoss(batch_.targets[at + i], colors[i], backdrops_, derivatives[i]);
        },
        tape_, level_.gradient.data());
    if (directional()) chainColors(from_, shown_, level_);
}

void LevelFit::update(int number, double done, std::size_t piece, double smoothness) {
    const double count = double(pass_.pieces[piece].count);
    differentiate(pass_, piece);
    result_.samples += double(tape_.samples);
    error_ += batch_.error();
    seen_ += count;
    if (number % kSmoothEvery == 0) smooth(count / double(kept_), smoothness);
    step(number, done);
    ++result_.updates;
}

void LevelFit::smooth(double raysPerVoxel, double smoothness) {
    const float weight = float(raysPerVoxel * kSmoothEvery);
    SmoothWeights weights;
    weights.extinction = weights.color = weight * float(smoothness);
    weights.sparsity = weight * float(options_.sparsity);
    parallelFor(level_.layout.brickCount() - 1, [&](std::size_t n) {
        smoothBrick(level_.layout, level_.voxels.data(), n + 1, weights, level_.gradient.data() + (n + 1) * 512);
    });
    if (directional())
        smoothSlopes({weight * float(options_.smoothSlopes), weight * float(options_.pullSlopes)}, level_);
}

void LevelFit::step(int number, double done) {
    AdamStep step;
    const double rate = std::pow(options_.lastRate, done);
    step.extinctionRate = float(options_.extinctionRate * rate);
    step.colorRate = float(options_.colorRate * rate);
    step.correction1 = 1 / (1 - std::pow(step.decay1, float(number + 1)));
    step.correction2 = 1 / (1 - std::pow(step.decay2, float(number + 1)));
    if (directional()) {
        AdamStep slopes = step;
        slopes.colorRate = float(options_.slopeRate * rate);
        stepSlopes(slopes, level_);
    }
    parallelFor(level_.layout.brickCount() - 1, [&](std::size_t n) {
        const std::size_t first = (n + 1) * 512;
        stepBrick(level_.voxels.data() + first, level_.gradient.data() + first, level_.moments.data() + first,
                  {level_.layout.masks[n + 1], level_.solid[n + 1]}, step);
    });
}

/// By some of the pixels that are left out, the next each time.
void LevelFit::tune(Smoothness& smoothness) {
    if (nextLeftOut_ == leftOut_.pieces.size()) {
        leftOut_ = passOver(sets_.leftOut, std::max<std::size_t>(1, std::size_t(options_.raysPerUpdate) / 4));
        nextLeftOut_ = 0;
    }
    if (leftOut_.pieces.empty()) return;
    differentiate(leftOut_, nextLeftOut_++);
    const std::size_t bricks = level_.layout.brickCount() - 1;
    std::vector<double> helps(bricks);
    parallelFor(bricks, [&](std::size_t n) {
        const std::size_t first = (n + 1) * 512;
        CompositeVoxel* gradient = level_.gradient.data() + first;
        helps[n] = smoothingHelps(level_.layout, level_.voxels.data(), n + 1, gradient, &level_.moments[first]);
        std::fill_n(gradient, 512, CompositeVoxel());
        if (directional()) std::fill_n(level_.slopeGradient.data() + first, 512, ColorSlopes());
    });
    smoothness.follow(std::accumulate(helps.begin(), helps.end(), 0.0));
}

std::string LevelFit::howItGoes() const {
    return "fitting: " + std::to_string(level_.grid.resolution()) + " voxels along the longest edge, " +
           brief(-20 * std::log10(std::max(rms(error_, seen_), 1e-6)), 3) + " dB";
}

double LevelFit::leftOutError() {
    const PixelPieces all = passOver(sets_.leftOut, std::max<std::size_t>(1, sets_.leftOut.size()));
    double squares = 0;
    for (const PixelPieces::Piece& piece : all.pieces) {
        const std::uint32_t* chosen = all.pixels.data() + piece.first;
        batch_.set(pixels_, chosen, piece.count, level_, options_.samplesPerSlice);
        std::vector<RayColor> colors(piece.count);
        composite(level_.layout, shownTo(*chosen), batch_.rays.data(), piece.count, colors.data());
        for (std::size_t i = 0; i < colors.size(); ++i) {
            RayColor unused;
            batch_.errors[i] = pixelLoss(batch_.targets[i], colors[i], backdrops_, unused);
        }
        squares += batch_.error();
    }
    return rms(squares, double(all.pixels.size()));
}

void LevelFit::addPoint() {
    PhotoPoint point;
    point.updates = result_.updates;
    point.seconds = timer_.seconds();
    point.resolution = level_.grid.resolution();
    point.imageError = rms(error_, seen_);
    point.leftOut = leftOutError();
    result_.history.push_back(point);
    error_ = seen_ = 0;
}

}  // namespace raysweep
