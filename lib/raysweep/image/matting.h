/// What an object covers of each pixel of a picture, and what light it sends there: pictures freed of their backdrop.
///
/// A pixel shows C = Co + (1 - alpha) B: alpha is the part that the object covers, Co the light from there (already
/// multiplied by alpha), B the backdrop's colour. Everything is in linear light, where this mixture holds. One picture
/// has three numbers for the four unknowns, so every method but the pair knows or assumes something.
#pragma once

#include "raysweep/core/types.h"
#include "raysweep/image/image.h"

#include <cstddef>
#include <optional>
#include <vector>

namespace raysweep {

struct MattingOptions {
    /// Where alpha comes from.
    enum class Matting {
        alpha,       ///< the picture has it
        whiteBlack,  ///< two pictures, before a white and a black backdrop
        black,       ///< what is not dark before black
        white,       ///< what is not bright before white
        known,       ///< what has another colour than the backdrop
        masks        ///< a second picture says it
    };
    Matting matting = Matting::alpha;
    Color backdrop = Color(0, 0, 1);                         ///< known: linear, each in [0,1]
    Color whiteBackdrop = grey(1), blackBackdrop = grey(0);  ///< whiteBlack: linear, not negative, different
    /// known: distance of a colour from the backdrop, linear RGB, at which alpha leaves 0 and reaches 1; 0 <= nearest <
    /// farthest. An opaque colour F that is nearer than `farthest` comes out too transparent.
    double nearest = 0.05, farthest = 0.3;
    /// black, white: what counts as backdrop, in display-encoded value, where noise is alike in dark and bright: alpha
    /// is 0 up to `threshold` and 1 from twice that, in (0,0.5].
    double threshold = 0.05;
    /// black, white, known: such gaps in the object are made opaque, as share of the picture, in [0,1]. A shadow or a
    /// dark patch is small; a gap that can be seen through is mostly larger, and must stay open: filled, it would be
    /// matter in every view that looks through it, while of a wrong gap views that see it otherwise say nothing worse.
    double largestHole = 1e-3;
    /// alpha, whiteBlack: how far values may be from what is possible before a pixel counts as inconsistent, linear, in
    /// (0,1). The pictures' rounding to 8 bits moves them by less than 0.012.
    double tolerance = 0.05;
    int searchRadius = 8;        ///< whiteBlack: how far a misregistration is looked for, pixels, in [0,64]; 0: not
    bool straightAlpha = false;  ///< alpha: RGB is not yet multiplied by it (readImage always does that for files whose
                                 ///< format keeps them apart)

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

/// Both pictures of a pair do not show the same.
struct Misregistration {
    int x = 0, y = 0;              ///< what the white picture shows at (i,j), the black one shows at (i+x,j+y)
    double inconsistency = 0;      ///< mean square per pixel as the pictures are, linear
    double inconsistencyThen = 0;  ///< the same after moving the black one back
};

/// What was found in a picture, and done to it.
struct MatteReport {
    std::size_t pixels = 0;
    std::size_t covered = 0;       ///< pixels with alpha > 0
    std::size_t opaque = 0;        ///< pixels with alpha 1
    double coverage = 0;           ///< sum of alpha, pixels
    std::size_t inconsistent = 0;  ///< pixels that are any of the following
    std::size_t outOfRange = 0;    ///< alpha below 0 or above 1, or colour below 0, by more than the tolerance
    std::size_t disagreeing = 0;   ///< channels disagree about alpha; or colour where nothing is covered
    std::size_t holes = 0;         ///< gaps that were filled
    std::size_t holePixels = 0;    ///< in them
    std::optional<Misregistration> misregistration;
};

/// A picture freed of its backdrop.
struct Matte {
    Image image;                     ///< RGBA, linear, premultiplied; alpha in [0,1], colours not negative
    std::vector<char> inconsistent;  ///< of each pixel; empty if the method cannot know
    MatteReport report;
};

/// Alpha as the picture has it: 2 or 4 channels. @throw InvalidArgument if it has none, or for values not finite.
Matte matteOfAlpha(const Image& picture, const MattingOptions& options = {});

/// Triangulation (Smith, Blinn, "Blue screen matting", SIGGRAPH 1996, theorem 4): two backdrops W and B give six
/// equations for the four unknowns. Their least squares solution is
///
///     1 - alpha = (Cw - Cb).(W - B) / |W - B|^2,   Co = ((Cw - (1 - alpha) W) + (Cb - (1 - alpha) B)) / 2
///
/// i.e. channels are weighted by how much the backdrops differ in them, which is right for noise that is alike in all,
/// and both pictures' noise is halved in Co. That an equation too many is not met tells that the object moved, or that
/// light changed: those pixels are counted. A misregistration by whole pixels is found from the textures or colours
/// that then disagree; an object of one single grey agrees with itself anywhere, and nothing is found. The matte is
/// made of the pictures as they are.
/// @param onWhite, onBlack pictures of one size; alpha must be 1 if there is any
/// @throw InvalidArgument
Matte matteOfPair(const Image& onWhite, const Image& onBlack, const MattingOptions& options = {});

/// From the distance to the backdrop's colour: alpha = (|C - B| - nearest) / (farthest - nearest), within [0,1], and
/// Co = C - (1 - alpha) B, within [0,alpha], which takes the backdrop's share out of soft edges. As C - B = alpha (F -
/// B) for an object of colour F, this is exact for colours at the distance `farthest` (with `nearest` 0); nearer ones
/// come out too transparent, farther ones have edges too opaque, with some backdrop left in them. Light that the
/// backdrop throws on the object is not told from the object's colour. @throw InvalidArgument
Matte matteOfKnownBackdrop(const Image& picture, const MattingOptions& options = {});

/// For an opaque object before black (`Matting::black`) or white (`Matting::white`): with v the largest channel, or 1 -
/// the smallest, both display-encoded, alpha = v / threshold - 1, and Co = C - (1 - alpha) B, within [0,alpha].
/// @throw InvalidArgument
Matte matteOfThreshold(const Image& picture, const MattingOptions& options);

/// Alpha as `mask` says (one channel in [0,1], see readCoverage). Its size is the picture's, or a whole multiple or
/// fraction: several of its pixels are averaged, or one stands for several. What backdrop is mixed into soft edges is
/// not known: Co = alpha C. A picture with alpha of its own keeps it, as a factor. @throw InvalidArgument
Matte matteOfMask(const Image& picture, const Image& mask);

/// What the methods need.
struct MattingInput {
    Image picture;  ///< before the white backdrop if there is a pair
    Image partner;  ///< whiteBlack: the picture before black; masks: the mask; else empty
};

/// The method that the options name. @throw InvalidArgument as MattingOptions::validate and the method
Matte matteOf(const MattingInput& input, const MattingOptions& options);

}  // namespace raysweep
