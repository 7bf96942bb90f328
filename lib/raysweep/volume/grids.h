/// The grid types that Raysweep works with. Instantiating OpenVDB's trees is what makes compilation slow, so it
/// happens once, in grids.cpp; every other unit includes this header and nothing else of OpenVDB's grid headers.
#pragma once

#include <openvdb/openvdb.h>

extern template class openvdb::tree::Tree<openvdb::tree::RootNode<
    openvdb::tree::InternalNode<openvdb::tree::InternalNode<openvdb::tree::LeafNode<float, 3>, 4>, 5>>>;
extern template class openvdb::tree::Tree<openvdb::tree::RootNode<
    openvdb::tree::InternalNode<openvdb::tree::InternalNode<openvdb::tree::LeafNode<openvdb::Vec3s, 3>, 4>, 5>>>;
extern template class openvdb::Grid<openvdb::FloatTree>;
extern template class openvdb::Grid<openvdb::Vec3STree>;

namespace raysweep {

/// Registers the grid types with OpenVDB; cheap to call again. Call it before reading or writing files.
void initializeGrids();

}  // namespace raysweep
