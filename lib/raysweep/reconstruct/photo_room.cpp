#include "raysweep/reconstruct/photo_room.h"

#include "raysweep/core/memory.h"

namespace raysweep {

bool hasRoom(double voxels, std::size_t bytesPerVoxel) {
    return double(residentBytes()) + voxels * double(bytesPerVoxel) <= double(physicalBytes());
}

void requireRoom(double voxels, std::size_t bytesPerVoxel) {
    requireBytes(double(residentBytes()) + voxels * double(bytesPerVoxel), "photographs and volume need at least",
                 "choose fewer voxels, or a smaller box", Remedy::giveGrid);
}

}  // namespace raysweep
