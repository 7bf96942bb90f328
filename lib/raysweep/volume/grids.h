/// The grid types that Raysweep works with. Instantiating OpenVDB's trees is what makes compilation slow: those of
/// floats and colours are compiled in grids.cpp, whole; other units compile only the member templates that they call.
/// This header is precompiled for the library, the command and the tests.
#pragma once

#include "raysweep/core/error.h"

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

/// Calls `visit` with the grid as the type that it is, and returns what it returns.
/// @throw InvalidArgument if that is neither FloatGrid nor Vec3SGrid.
template <class Visit>
auto withTypedGrid(const openvdb::GridBase& grid, const Visit& visit) {
    if (grid.isType<openvdb::FloatGrid>()) return visit(static_cast<const openvdb::FloatGrid&>(grid));
    if (grid.isType<openvdb::Vec3SGrid>()) return visit(static_cast<const openvdb::Vec3SGrid&>(grid));
    throw InvalidArgument("grid '" + grid.getName() + "' is of type " + grid.type() +
                          "; only float and vec3s grids can be used here");
}

}  // namespace raysweep
