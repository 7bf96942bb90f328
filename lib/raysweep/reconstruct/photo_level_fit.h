/// The updates of a fit of photographs at one resolution.
#pragma once

#include "raysweep/core/parallel.h"
#include "raysweep/core/progress.h"
#include "raysweep/reconstruct/photo_directional.h"
#include "raysweep/reconstruct/photo_fit.h"
#include "raysweep/reconstruct/photo_level.h"
#include "raysweep/reconstruct/photo_pieces.h"
#include "raysweep/reconstruct/photo_pixels.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <string>
#include <vector>

namespace raysweep {

/// How smooth the volume is kept follows from pixels that are left out. Every now and then their loss is differentiated
/// along what a step of smoothing does: if less variation would meet them better it weighs more (J. Luketina and
/// others, "Scalable Gradient-Based Tuning of Continuous Regularization Hyperparameters", ICML 2016). Colour is asked,
/// extinction goes along: while surfaces are still getting sharper, smoothing them looks worse than it proves to be.
class Smoothness {
  public:
    explicit Smoothness(double weight) : weight_(weight) {}

    double weight() const { return weight_; }

    /// Adam on the logarithm of the weight. @param helps as smoothingHelps, of the whole volume
    void follow(double helps) {
        constexpr double kRate = 0.15, kKeep = 0.7, kKeepSquare = 0.9;
        mean_ = kKeep * mean_ + (1 - kKeep) * helps;
        square_ = kKeepSquare * square_ + (1 - kKeepSquare) * helps * helps;
        constexpr double kLeast = 1e-6, kMost = 1;
        if (square_ > 0) weight_ = std::clamp(weight_ * std::exp(kRate * mean_ / std::sqrt(square_)), kLeast, kMost);
    }

  private:
    double weight_, mean_ = 0, square_ = 0;
};

/// Update after update: rays of some random pixels, the derivative of their loss, now and then smoothness, a step of
/// all bricks.
class LevelFit {
  public:
    /// @param level what there is to be fitted; it and all others are kept by reference
    /// @param timer since the fit began @param result gets history, times and counts
    LevelFit(PhotoLevel& level, const PhotoPixels& pixels, const PhotoFitOptions& options, const Timer& timer,
             PhotoReconstruction& result);

    /// @param smoothness to begin with, and what it has become
    /// @param from, to part of the whole fit that this is, for the callback
    /// @return false if the callback said stop
    bool run(double passes, Smoothness& smoothness, const ProgressCallback& progress, double from, double to);

  private:
    bool directional() const { return !level_.slopes.empty(); }
    PixelPieces passOver(const std::vector<std::uint32_t>& pixels, std::size_t most);
    const CompositeVoxel* shownTo(std::uint32_t pixel);
    void differentiate(const PixelPieces& pass, std::size_t piece);
    void update(int number, double done, std::size_t piece, double smoothness);
    void smooth(double raysPerVoxel, double smoothness);
    void step(int number, double done);
    void tune(Smoothness& smoothness);
    std::string howItGoes() const;
    double leftOutError();
    void addPoint();

    PhotoLevel& level_;
    const PhotoPixels& pixels_;
    const PhotoFitOptions& options_;
    const Timer& timer_;
    PhotoReconstruction& result_;
    Backdrops backdrops_;
    PixelSets sets_;
    std::mt19937 random_;
    PixelPieces pass_, leftOut_;   ///< over the fitted pixels, and over those that are left out
    std::size_t nextLeftOut_ = 0;  ///< piece
    ViewPoint from_;
    std::vector<CompositeVoxel> shown_;  ///< to the rays from there, where colours depend on the direction
    std::size_t kept_;
    PhotoBatch batch_;
    CompositeTape tape_;
    double error_ = 0, seen_ = 0;  ///< since the last point of the history
};

}  // namespace raysweep
