#include "raysweep/bricks/bricks.h"

#include "raysweep/core/parallel.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstring>
#include <new>

namespace raysweep {

BrickField::BrickField(std::size_t brickCount) : brickCount_(brickCount) {
    // Large fields on large pages: a sweep walks through several fields at once, and page tables would be a cost of
    // their own.
    constexpr std::size_t kLine = 64, kLargePage = 2 << 20;
    const std::size_t brickBytes = kBrickVoxels * sizeof(float),
                      bytes = std::max(brickCount, std::size_t(1)) * brickBytes;
    const std::size_t alignment = bytes >= kLargePage ? kLargePage : kLine;
    void* memory = std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
    if (!memory) throw std::bad_alloc();
    if (alignment == kLargePage) ::madvise(memory, bytes, MADV_HUGEPAGE);
    data_.reset(static_cast<float*>(memory));
    parallelFor(
        brickCount, [&](std::size_t b) { std::memset(brick(b), 0, brickBytes); }, 64);
}

}  // namespace raysweep
