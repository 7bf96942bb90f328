#include "raysweep/reconstruct/sart_record.h"

#include "raysweep/phantoms/ct_phantoms.h"
#include "raysweep/projector/project_grid.h"
#include "raysweep/volume/vdb_io.h"

#include "support/temporary_folder.h"
#include "support/volumes.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstring>
#include <fstream>
#include <limits>
#include <map>

using namespace raysweep;

namespace {

const ReconstructionGrid kGrid{Index3(24, 24, 20), Vec3(0, 0, 0), Vec3(1)};

/// Of a box with holes; one ray was not measured.
Scan smallScan(BeamShape beam) {
    PhantomOptions options;
    options.dims = openvdb::Coord(24, 24, 20);
    CircularOrbit orbit;
    orbit.beam = beam;
    orbit.views = 11;
    orbit.width = 38;
    orbit.height = 26;
    orbit.sourceToAxis = orbit.sourceToDetector = 100;
    Scan scan;
    scan.geometry = circularGeometry(orbit);
    scan.projections = projectGrid(*makeBoxWithHoles(options), scan.geometry);
    scan.projections.view(3)[5] = std::numeric_limits<float>::quiet_NaN();
    return scan;
}

SartRecord recordOf(const Scan& scan, SartOptions options, const SartVolumes& volumes = {}) {
    SartRecord record;
    options.record = &record;
    sart(scan.projections, scan.geometry, kGrid, options, volumes);
    return record;
}

std::map<std::string, openvdb::FloatGrid::Ptr> gridsOf(const std::string& path) {
    std::map<std::string, openvdb::FloatGrid::Ptr> grids;
    for (const auto& grid : readVdb(path).grids)
        grids[grid->getName()] = openvdb::gridPtrCast<openvdb::FloatGrid>(grid);
    return grids;
}

}  // namespace

TEST(SartRecord, SaysTheShapeOfVoxels) {
    const test::TemporaryFolder folder;
    const Scan scan = smallScan(BeamShape::parallel);
    SartRecord record;
    SartOptions options;
    options.iterations = 1;
    options.record = &record;
    const ReconstructionGrid grid{Index3(24, 12, 8), Vec3(0), Vec3(1, 2, 2.5)};
    sart(scan.projections, scan.geometry, grid, options);
    writeRecord(folder / "run.json", record, scan);
    const nlohmann::json json = nlohmann::json::parse(std::ifstream(folder / "run.json"));
    EXPECT_EQ(json["grid"]["world_from_voxel"], nlohmann::json::parse("[[1.0,0,0],[0,2.0,0],[0,0,2.5]]"));
    EXPECT_EQ(gridsOf(folder / "run.vdb").at("density")->voxelSize(), openvdb::Vec3d(1, 2, 2.5));
}

TEST(SartRecord, HasEveryUpdateInItsOrder) {
    const Scan scan = smallScan(BeamShape::parallel);
    SartOptions options;
    options.iterations = 3;
    options.viewsPerUpdate = 4;
    options.relaxation = 0.8;
    options.relaxationDecay = 0.5;
    options.order = ViewOrder::random;
    const SartRecord record = recordOf(scan, options);
    ASSERT_EQ(record.updates.size(), 9u);  // 4, 4 and 3 views, three times
    for (int pass = 0; pass < 3; ++pass) {
        std::vector<int> views;
        for (std::size_t n = 0; n < 3; ++n) {
            const RecordedUpdate& update = record.updates[std::size_t(pass) * 3 + n];
            views.insert(views.end(), update.views.begin(), update.views.end());
            EXPECT_EQ(update.relaxation, 0.8 / (1 + 0.5 * pass));
        }
        EXPECT_EQ(views, viewOrder(scan.geometry, options.order, options.seed, pass));
    }
    options.viewsPerUpdate = 0;
    EXPECT_EQ(recordOf(scan, options).updates.size(), 3u);
}

TEST(SartRecord, HoldsWhatWasReconstructed) {
    const Scan scan = smallScan(BeamShape::parallel);
    SartOptions options;
    options.lower = 0;
    options.tolerance = 0.05;
    const openvdb::FloatGrid::Ptr pruned = sart(scan.projections, scan.geometry, kGrid, options).volume;
    options.tolerance = 0;
    const openvdb::FloatGrid::Ptr volume = sart(scan.projections, scan.geometry, kGrid, options).volume;
    options.tolerance = 0.05;
    const SartRecord record = recordOf(scan, options);
    EXPECT_TRUE(test::sameBits(*record.density, *volume));
    EXPECT_FALSE(test::sameBits(*record.density, *pruned));
    EXPECT_FALSE(record.initial);
    ASSERT_TRUE(record.support);
    for (auto value = volume->cbeginValueOn(); value; ++value)
        EXPECT_EQ(record.support->tree().getValue(value.getCoord()), 1);
    EXPECT_LT(record.support->activeVoxelCount(), 24u * 24 * 20);

    options.support = Support::none;
    const SartRecord again = recordOf(scan, options, {volume, nullptr});
    EXPECT_FALSE(again.support);
    EXPECT_TRUE(test::sameBits(*again.initial, *volume));
}

TEST(SartRecord, FilesHoldProjectionsAsTheyWereGiven) {
    const test::TemporaryFolder folder;
    for (const BeamShape beam : {BeamShape::parallel, BeamShape::cone}) {
        const Scan scan = smallScan(beam);
        SartOptions options;
        options.iterations = 1;
        options.lower = 0;
        writeRecord(folder / "run.json", recordOf(scan, options), scan);
        const auto grids = gridsOf(folder / "run.vdb");
        ASSERT_EQ(grids.size(), 3u);  // density and support, too
        const openvdb::FloatGrid& projections = *grids.at("projections");
        ASSERT_EQ(projections.activeVoxelCount(), 38u * 26 * 11);
        for (int view = 0; view < 11; ++view)
            for (int row = 0; row < 26; ++row)
                for (int column = 0; column < 38; ++column) {
                    const float value = projections.tree().getValue(openvdb::Coord(column, row, view));
                    ASSERT_EQ(std::memcmp(&value, scan.projections.view(view) + row * 38 + column, sizeof value), 0);
                }

        const nlohmann::json json = nlohmann::json::parse(std::ifstream(folder / "run.json"));
        EXPECT_EQ(json["raysweep_record"], "reconstruct");
        EXPECT_EQ(json["grid"]["dims"], nlohmann::json::array({24, 24, 20}));
        EXPECT_EQ(json["grid"]["origin"], nlohmann::json::array({-11.5, -11.5, -9.5}));
        EXPECT_EQ(json["grid"]["world_from_voxel"][1], nlohmann::json::array({0, 1.0, 0}));
        EXPECT_EQ(json["lower"], 0.0);
        EXPECT_TRUE(json["upper"].is_null() && json["saturation"].is_null());
        EXPECT_EQ(json["updates"].size(), 11u);
        const nlohmann::json& view = json["geometry"]["views"][2];
        EXPECT_EQ(view.contains("source"), beam == BeamShape::cone);
        EXPECT_EQ(view.contains("direction"), beam == BeamShape::parallel);
        for (std::size_t axis = 0; axis < 3; ++axis)
            EXPECT_EQ(view["origin"][axis], scan.geometry.views[2].origin[int(axis)]);
    }
}
