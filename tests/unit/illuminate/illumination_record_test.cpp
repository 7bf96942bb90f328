// What a record of a solution holds is enough to make its sweeps again.
#include "raysweep/illuminate/illumination_record.h"

#include "raysweep/bricks/brick_grids.h"
#include "raysweep/bricks/field_grids.h"
#include "raysweep/core/error.h"
#include "raysweep/illuminate/illuminate.h"
#include "raysweep/illuminate/state.h"
#include "raysweep/volume/statistics.h"
#include "raysweep/volume/vdb_io.h"

#include "support/expect_error.h"
#include "support/temporary_folder.h"
#include "support/volumes.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>

using namespace raysweep;

namespace {

constexpr double kRounding = 1e-6;

Scene cloudScene(int edge) {
    Scene scene;
    scene.medium.density = test::cloudVolume(edge);
    scene.medium.extinctionScale = 0.125;  // a power of two: extinction has the bits that the solver has
    scene.suns.push_back({Vec3(0.3, -0.2, -1), grey(3)});
    scene.sky.radiance = grey(0.125f);
    return scene;
}

IlluminateOptions sweeping(int sweeps) {
    IlluminateOptions options;
    options.tolerance = 0;
    options.sweeps = sweeps;
    return options;
}

/// What the record says that sweeps begin with.
SolverState stateFrom(const IlluminationRecord& record) {
    std::vector<openvdb::GridBase::ConstPtr> grids{record.extinction};
    if (record.source) grids.push_back(record.source);  // emission may lie beside the extinction
    BrickLayout layout = layoutBricks(grids, 4);
    Escape escape(layout.worldFromIndex);
    SolverState state(std::move(layout), {false, false, false}, std::move(escape));
    MediumFields& medium = state.medium;
    const BrickLayout& bricks = medium.volume.layout;
    medium.model = record.asPrinted ? ExchangeModel::asPrinted : ExchangeModel::corrected;
    medium.channels = record.channels;
    medium.tau = gatherField(bricks, *record.extinction, medium.escape.meanStepLength());
    medium.uniformAlbedo = !record.albedoGrid;
    state.power.zero = BrickField(1);
    IlluminateOptions options;
    options.interpolation = record.interpolation;
    allocateSweepFields(state, options);
    for (int c = 0; c < record.channels; ++c) {
        if (record.albedoGrid) {
            medium.albedo[c] = gatherChannel(bricks, *record.albedoGrid, c, 1);
        } else {
            medium.albedo[c] = BrickField(1);
            std::fill_n(medium.albedo[c].brick(0), kBrickVoxels, float(record.albedo[c]));
        }
        if (record.source) state.power.source[c] = gatherChannel(bricks, *record.source, c, 1);
        if (record.unshotStart) state.power.unshot[c] = gatherChannel(bricks, *record.unshotStart, c, 1);
    }
    return state;
}

std::vector<Beam> beamsOf(const RecordedGroup& group, const IlluminationRecord& record, const SolverState& state) {
    const int reach = record.interpolation == Interpolation::linear ? 1 : 0;
    std::vector<Beam> beams;
    for (const RecordedBeam& recorded : group.beams) {
        beams.push_back(darkBeam(state.medium, parallelFront(state.medium.volume.layout, recorded.direction, reach,
                                                             {recorded.column, recorded.row}, {false, false, false})));
        for (int c = 0; c < record.channels; ++c) beams.back().entering[c] = float(recorded.entering[c]);
    }
    return beams;
}

/// Makes the recorded sweeps; what rays carry and what is unshot must come out as recorded.
void replay(const IlluminationRecord& record, SolverState& state) {
    ExchangeConstants constants;
    constants.model = state.medium.model;
    constants.escape = state.medium.escape.fit();
    constants.zeta = float(record.zeta);
    constants.mostShot = float(record.mostShot);
    int injections = 0;
    for (const RecordedGroup& group : record.groups) {
        const std::vector<Beam> beams = beamsOf(group, record, state);
        const ExchangeFields fields = exchangeFields(state, group.inject);
        const std::vector<RaySums> sums = sweep(state.medium.volume, beams, record.interpolation, fields, constants);
        if (record.interpolation == Interpolation::linear) settle(state.medium.volume, beams, fields, constants);
        for (int c = 0; c < record.channels; ++c) {
            EXPECT_EQ(unshotPower(state).value[c], group.unshot.value[c]);
            for (std::size_t i = 0; i < beams.size(); ++i) {
                EXPECT_EQ(sums[i].entered[c], group.beams[i].sums.entered[c]);
                EXPECT_EQ(sums[i].escaped[c], group.beams[i].sums.escaped[c]);
            }
        }
        if (group.inject) injections += int(beams.size());
    }
    EXPECT_EQ(injections, record.injections);
}

/// Lights and records the scene, and makes the sweeps again.
IlluminationRecord expectSameBits(const Scene& scene, IlluminateOptions options) {
    IlluminationRecord record;
    const Illumination unrecorded = illuminate(scene, options);
    options.record = &record;
    const Illumination lit = illuminate(scene, options);
    EXPECT_TRUE(test::sameBits(*lit.radiosity, *unrecorded.radiosity)) << "recording changes the answer";
    EXPECT_EQ(record.injections, lit.sweeps);

    SolverState state = stateFrom(record);
    const BrickLayout& layout = state.medium.volume.layout;
    EXPECT_EQ(layout.low, record.low);
    EXPECT_EQ(layout.high, record.high);
    EXPECT_EQ(layout.worldFromIndex, record.worldFromIndex);
    replay(record, state);
    const openvdb::math::Transform& transform = scene.medium.density->transform();
    std::vector<BrickField> deposit(std::size_t(record.channels));
    for (int c = 0; c < record.channels; ++c) {
        deposit[std::size_t(c)] = BrickField(layout.brickCount());
        for (std::size_t b = 0; b < layout.brickCount(); ++b)
            for (int i = 0; i < kBrickVoxels; ++i)
                deposit[std::size_t(c)].brick(b)[i] =
                    state.power.total[c].brick(b)[i] + state.power.recent[c].brick(b)[i];
    }
    // Here they are added up in one float, there in two from time to time.
    EXPECT_LE(compareGrids(*sparseGridFromFields(layout, transform, deposit.data(), record.channels), *record.deposit)
                  .relativeRmse,
              kRounding);
    EXPECT_TRUE(
        test::sameBits(*sparseGridFromFields(layout, transform, state.power.unshot, record.channels), *record.unshot));
    EXPECT_GT(record.deposit->activeVoxelCount(), 0u);
    return record;
}

std::size_t mostTogether(const IlluminationRecord& record) {
    std::size_t most = 0;
    for (const RecordedGroup& group : record.groups) most = std::max(most, group.beams.size());
    return most;
}

nlohmann::json jsonOfFile(const std::string& path) {
    return nlohmann::json::parse(std::ifstream(path));
}

}  // namespace

TEST(IlluminationRecord, SweepsFromACoarseStartAreMadeAgain) {
    IlluminateOptions options = sweeping(250);
    options.batch = 250;  // enough directions for groups that are full
    const IlluminationRecord record = expectSameBits(cloudScene(48), options);
    EXPECT_EQ(mostTogether(record), 8u);
    EXPECT_TRUE(record.unshotStart);
    EXPECT_TRUE(record.settled);
    EXPECT_TRUE(record.settledDeposit);
    EXPECT_FLOAT_EQ(float(record.zeta), 0.0125f);
    EXPECT_FLOAT_EQ(float(record.mostShot), 0.125f);
}

TEST(IlluminationRecord, SweepsFromTheDarkAndThoseThatFinishAreMadeAgain) {
    IlluminateOptions options = sweeping(45);
    options.darkStart = true;
    options.unshotShare = 1e-9;
    const IlluminationRecord record = expectSameBits(cloudScene(32), options);
    EXPECT_FALSE(record.unshotStart);
    EXPECT_FALSE(record.settled);
    EXPECT_FALSE(record.settledDeposit);
    EXPECT_GT(record.groups.size(), 45u + 20u);
    EXPECT_FALSE(record.groups.back().inject);
}

TEST(IlluminationRecord, LinearSweepsAreMadeAgain) {
    IlluminateOptions options = sweeping(24);
    options.interpolation = Interpolation::linear;
    EXPECT_EQ(expectSameBits(cloudScene(48), options).interpolation, Interpolation::linear);
}

TEST(IlluminationRecord, ColouredSweepsAreMadeAgain) {
    Scene scene = cloudScene(48);
    scene.suns[0].irradiance = Color(3, 2, 1);
    scene.points.push_back({Vec3(-5, 20, 60), Color(100, 200, 300)});
    EXPECT_TRUE(expectSameBits(scene, sweeping(24)).otherSources);
    const auto albedo = openvdb::Vec3SGrid::create();
    albedo->denseFill({openvdb::Coord(0), openvdb::Coord(47)}, openvdb::Vec3s(0.9f, 0.5f, 0.99f));
    scene.medium.albedoGrid = albedo;
    EXPECT_TRUE(expectSameBits(scene, sweeping(24)).albedoGrid);
}

TEST(IlluminationRecord, EmissionBesideTheMediumIsMadeAgain) {
    Scene scene = cloudScene(48);
    const auto emission = openvdb::FloatGrid::create();
    emission->setTransform(scene.medium.density->transform().copy());
    emission->denseFill({openvdb::Coord(60, 10, 10), openvdb::Coord(66, 20, 20)}, 2.0f);
    scene.medium.emission = emission;
    const IlluminationRecord record = expectSameBits(scene, sweeping(24));
    EXPECT_TRUE(record.otherSources);
    EXPECT_GT(record.high.x, 66);
}

TEST(IlluminationRecord, ThePapersExchangeIsMadeAgain) {
    IlluminateOptions options = sweeping(24);
    options.exchange = Exchange::paper;
    options.remaining = Remaining::drop;
    EXPECT_TRUE(expectSameBits(cloudScene(32), options).asPrinted);
}

TEST(IlluminationRecord, WhatIsSpreadAtTheEndIsNoSweep) {
    IlluminateOptions options = sweeping(24);
    options.remaining = Remaining::spread;
    const IlluminationRecord record = expectSameBits(cloudScene(32), options);
    EXPECT_FALSE(record.settled);
    ASSERT_TRUE(record.settledDeposit);
    // All that was unshot was deposited, to the accuracy of floats.
    double spread = 0;
    for (auto value = openvdb::gridPtrCast<openvdb::FloatGrid>(record.settledDeposit)->cbeginValueOn(); value; ++value)
        spread += double(*value);
    const double unshot = record.groups.back().unshot.sum();
    EXPECT_NEAR(spread, unshot, 1e-5 * unshot);
}

TEST(IlluminationRecord, WithoutSweepsThereIsDirectLightAlone) {
    IlluminationRecord record;
    IlluminateOptions options = sweeping(0);
    options.record = &record;
    illuminate(cloudScene(32), options);
    EXPECT_TRUE(record.groups.empty());
    EXPECT_TRUE(record.source && record.extinction);
    EXPECT_TRUE(record.deposit->empty() && record.unshot->empty());
}

TEST(IlluminationRecord, IsRefusedWhereItWouldNotBeEnough) {
    IlluminationRecord record;
    const auto light = [&](const Scene& scene, IlluminateOptions options) {
        options.record = &record;
        illuminate(scene, options);
    };
    IlluminateOptions options = sweeping(4);
    options.periodic = {true, false, false};
    test::expectError<InvalidArgument>([&] { light(cloudScene(16), options); }, "record: a periodic volume");
}

TEST(IlluminationRecord, FilesHoldWhatTheRecordHolds) {
    IlluminationRecord record;
    IlluminateOptions options = sweeping(24);
    options.record = &record;
    illuminate(cloudScene(48), options);
    record.density = "smoke";
    record.checksum = "0123456789abcdef";
    const test::TemporaryFolder folder;
    writeRecord(folder / "run.json", record);
    const nlohmann::json json = jsonOfFile(folder / "run.json");
    EXPECT_EQ(json["raysweep_record"], "illuminate");
    EXPECT_EQ(json["fields"], "run.vdb");
    EXPECT_EQ(json["volume"]["grid"], "smoke");
    EXPECT_EQ(json["volume"]["checksum"], "0123456789abcdef");
    EXPECT_EQ(json["albedo"], nlohmann::json::array({double(0.9f)}));
    EXPECT_EQ(json["power_unit"], record.powerUnit);
    EXPECT_EQ(json["zeta"], record.zeta);
    ASSERT_EQ(json["groups"].size(), record.groups.size());
    const RecordedGroup& group = record.groups.front();
    EXPECT_EQ(json["groups"][0]["inject"], true);
    EXPECT_EQ(json["groups"][0]["unshot"][0], group.unshot.value[0]);
    const nlohmann::json& beam = json["groups"][0]["beams"][0];
    for (int axis = 0; axis < 3; ++axis)
        EXPECT_EQ(beam["direction"][std::size_t(axis)], group.beams[0].direction[axis]);
    EXPECT_EQ(beam["offset"], nlohmann::json::array({group.beams[0].column, group.beams[0].row}));
    EXPECT_EQ(beam["entering"][0], group.beams[0].entering[0]);
    EXPECT_EQ(beam["entered"][0], group.beams[0].sums.entered[0]);

    const VdbFile file = readVdb(folder / "run.vdb");
    std::set<std::string> names;
    for (const auto& grid : file.grids) {
        names.insert(grid->getName());
        if (grid->getName() == "deposit") {
            EXPECT_TRUE(test::sameBits(*grid, *record.deposit));
        }
    }
    const std::set<std::string> expected = {"extinction", "source", "unshot_start", "deposit", "unshot", "settled"};
    EXPECT_EQ(names, expected);
}

TEST(IlluminationRecord, BothFilesAppearOrNone) {
    IlluminationRecord record;
    IlluminateOptions options = sweeping(4);
    options.record = &record;
    illuminate(cloudScene(16), options);
    const test::TemporaryFolder folder;
    std::filesystem::create_directory(folder / "run.vdb");
    EXPECT_THROW(writeRecord(folder / "run.json", record), IoError);
    std::filesystem::remove(folder / "run.vdb");
    EXPECT_TRUE(folder.isEmpty());
}
