#include "raysweep/volume/grids.h"

#include <openvdb/io/DelayedLoadMetadata.h>

template class openvdb::tree::Tree<openvdb::tree::RootNode<
    openvdb::tree::InternalNode<openvdb::tree::InternalNode<openvdb::tree::LeafNode<float, 3>, 4>, 5>>>;
template class openvdb::tree::Tree<openvdb::tree::RootNode<
    openvdb::tree::InternalNode<openvdb::tree::InternalNode<openvdb::tree::LeafNode<openvdb::Vec3s, 3>, 4>, 5>>>;
template class openvdb::Grid<openvdb::FloatTree>;
template class openvdb::Grid<openvdb::Vec3STree>;

namespace raysweep {

void initializeGrids() {
    openvdb::initialize();
    // Helps who reads leaves when they are needed; what reads it makes room for whatever a damaged file says.
    openvdb::Metadata::unregisterType(openvdb::io::DelayedLoadMetadata::staticTypeName());
}

}  // namespace raysweep
