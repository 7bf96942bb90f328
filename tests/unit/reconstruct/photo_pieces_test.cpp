#include "raysweep/reconstruct/photo_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace raysweep {
namespace {

/// Every pixel once, in pieces that leave no gap.
void expectAllOnce(const PixelPieces& pieces, std::vector<std::uint32_t> pixels) {
    std::vector<PixelPieces::Piece> inOrder = pieces.pieces;
    std::sort(inOrder.begin(), inOrder.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::size_t next = 0;
    for (const PixelPieces::Piece& piece : inOrder) {
        EXPECT_EQ(piece.first, next);
        next += piece.count;
    }
    EXPECT_EQ(next, pixels.size());
    std::vector<std::uint32_t> sorted = pieces.pixels;
    std::sort(sorted.begin(), sorted.end());
    EXPECT_EQ(sorted, pixels);
    EXPECT_NE(pieces.pixels, pixels);  // shuffled
}

TEST(PhotoPieces, EqualAndComplete) {
    std::vector<std::uint32_t> pixels(1000);
    std::iota(pixels.begin(), pixels.end(), 7u);
    std::mt19937 random(1);
    const PixelPieces pieces = shuffledPieces(pixels, 300, random);
    ASSERT_EQ(pieces.pieces.size(), 4u);
    for (const PixelPieces::Piece& piece : pieces.pieces) EXPECT_EQ(piece.count, 250u);
    expectAllOnce(pieces, pixels);
    EXPECT_TRUE(shuffledPieces({}, 300, random).pieces.empty());
}

TEST(PhotoPieces, OfOneViewEach) {
    std::vector<Photograph> photographs(3);
    for (Photograph& photograph : photographs) photograph.matte = Image(10, 8, 4);
    const PhotoPixels all(photographs);
    std::vector<std::uint32_t> pixels(all.count());
    std::iota(pixels.begin(), pixels.end(), 0u);
    std::mt19937 random(1);
    const PixelPieces pieces = shuffledPiecesOfViews(all, pixels, 50, random);
    ASSERT_EQ(pieces.pieces.size(), 6u);
    for (const PixelPieces::Piece& piece : pieces.pieces) {
        EXPECT_EQ(piece.count, 40u);
        for (std::size_t i = 0; i < piece.count; ++i)
            EXPECT_EQ(all.view(pieces.pixels[piece.first + i]), all.view(pieces.pixels[piece.first]));
    }
    expectAllOnce(pieces, pixels);
}

}  // namespace
}  // namespace raysweep
