#include "raysweep/reconstruct/photo_pieces.h"

#include "raysweep/core/shuffle.h"

#include <algorithm>

namespace raysweep {
namespace {

void addPieces(std::size_t first, std::size_t count, std::size_t most, std::vector<PixelPieces::Piece>& pieces) {
    const std::size_t parts = (count + most - 1) / most;
    for (std::size_t n = 0; n < parts; ++n) {
        const std::size_t begin = n * count / parts, end = (n + 1) * count / parts;
        pieces.push_back({first + begin, end - begin});
    }
}

}  // namespace

PixelPieces shuffledPieces(const std::vector<std::uint32_t>& pixels, std::size_t most, std::mt19937& random) {
    PixelPieces to;
    to.pixels = pixels;
    shuffle(to.pixels, random);
    addPieces(0, to.pixels.size(), most, to.pieces);
    return to;
}

PixelPieces shuffledPiecesOfViews(const PhotoPixels& all, const std::vector<std::uint32_t>& pixels, std::size_t most,
                                  std::mt19937& random) {
    PixelPieces to;
    to.pixels = pixels;
    shuffle(to.pixels, random);
    std::stable_sort(to.pixels.begin(), to.pixels.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return all.view(a) < all.view(b); });
    for (std::size_t first = 0, last = 0; first < to.pixels.size(); first = last) {
        const int view = all.view(to.pixels[first]);
        while (last < to.pixels.size() && all.view(to.pixels[last]) == view) ++last;
        addPieces(first, last - first, most, to.pieces);
    }
    shuffle(to.pieces, random);
    return to;
}

}  // namespace raysweep
