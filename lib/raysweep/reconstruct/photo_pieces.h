/// Pixels in the order of a pass, in pieces for one update each.
#pragma once

#include "raysweep/reconstruct/photo_pixels.h"

#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace raysweep {

/// Some pixels, each once.
struct PixelPieces {
    struct Piece {
        std::size_t first, count;
    };
    std::vector<std::uint32_t> pixels;
    std::vector<Piece> pieces;
};

/// In a random order. Pieces are of equal size as far as that goes: steps are.
/// @param most pixels in a piece, > 0
PixelPieces shuffledPieces(const std::vector<std::uint32_t>& pixels, std::size_t most, std::mt19937& random);

/// The same in pieces of one view each, these in a random order.
PixelPieces shuffledPiecesOfViews(const PhotoPixels& all, const std::vector<std::uint32_t>& pixels, std::size_t most,
                                  std::mt19937& random);

}  // namespace raysweep
