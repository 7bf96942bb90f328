#include "raysweep/reconstruct/sart_record.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/scan/geometry_json.h"
#include "raysweep/volume/record_file.h"

#include <nlohmann/json.hpp>

#include <memory>

namespace raysweep {
namespace {

using Json = nlohmann::ordered_json;
using openvdb::Coord;
using Leaf = openvdb::FloatTree::LeafNodeType;

Json describe(const ReconstructionGrid& grid) {
    const Vec3 origin = grid.voxel(0, 0, 0);
    const Vec3& edges = grid.spacing;
    return {{"dims", Json::array({grid.dims.x, grid.dims.y, grid.dims.z})},
            {"origin", Json::array({origin.x, origin.y, origin.z})},
            {"world_from_voxel",
             Json::array({Json::array({edges.x, 0, 0}), Json::array({0, edges.y, 0}), Json::array({0, 0, edges.z})})}};
}

Json describe(const ProjectionGeometry& geometry) {
    return {{"beam", geometry.beam == BeamShape::cone ? "cone" : "parallel"},
            {"width", geometry.width},
            {"height", geometry.height},
            {"views", jsonOfViews(geometry)}};
}

/// What is infinite is null in the file.
Json describe(const SartRecord& record, const Scan& scan, const std::string& path) {
    const SartOptions& options = record.options;
    Json json = recordHead("reconstruct", path);
    json["grid"] = describe(record.grid);
    json["geometry"] = describe(scan.geometry);
    json["relaxation"] = options.relaxation;
    json["relaxation_decay"] = options.relaxationDecay;
    json["lower"] = options.lower;
    json["upper"] = options.upper;
    json["total_variation"] = options.totalVariation;
    json["saturation"] = double(scan.projections.saturation);
    json["support"] = options.support == Support::automatic ? "automatic" : "none";
    json["updates"] = Json::array();
    for (const RecordedUpdate& update : record.updates)
        json["updates"].push_back({{"views", update.views}, {"relaxation", update.relaxation}});
    return json;
}

/// Voxel (column, row, view), all of them active.
openvdb::FloatGrid::Ptr gridOf(const Projections& projections) {
    const Coord dims(projections.width, projections.height, projections.views);
    std::vector<Coord> origins;
    for (int x = 0; x < dims.x(); x += int(Leaf::DIM))
        for (int y = 0; y < dims.y(); y += int(Leaf::DIM))
            for (int z = 0; z < dims.z(); z += int(Leaf::DIM)) origins.emplace_back(x, y, z);
    std::vector<std::unique_ptr<Leaf>> leaves(origins.size());
    parallelFor(origins.size(), [&](std::size_t n) {
        leaves[n] = std::make_unique<Leaf>(origins[n], 0.0f);
        for (openvdb::Index offset = 0; offset < Leaf::SIZE; ++offset) {
            const Coord at = leaves[n]->offsetToGlobalCoord(offset);
            if (at.x() >= dims.x() || at.y() >= dims.y() || at.z() >= dims.z()) continue;
            leaves[n]->setValueOn(
                offset, projections.view(at.z())[std::size_t(at.y()) * std::size_t(dims.x()) + std::size_t(at.x())]);
        }
    });
    const openvdb::FloatGrid::Ptr grid = openvdb::FloatGrid::create(0.0f);
    for (auto& leaf : leaves) grid->tree().addLeaf(leaf.release());
    return grid;
}

}  // namespace

void requireRecordable(const Scan& scan) {
    if (!scan.projections.bounds.empty())
        throw InvalidArgument("record: rays that say \"at most\", or \"at least\" by their counts, cannot be recorded");
}

void writeRecord(const std::string& path, const SartRecord& record, const Scan& scan) {
    requireRecordable(scan);
    openvdb::GridCPtrVec fields;
    const auto add = [&](const openvdb::FloatGrid::Ptr& grid, const char* name) {
        if (!grid) return;
        grid->setName(name);
        fields.push_back(grid);
    };
    add(gridOf(scan.projections), "projections");
    add(record.initial, "initial");
    add(record.density, "density");
    add(record.support, "support");
    writeRecordFiles(path, describe(record, scan, path), fields);
}

}  // namespace raysweep
