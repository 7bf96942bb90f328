#include "support/volumes.h"

#include "support/source_folder.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <random>
#include <stdexcept>

#include "raysweep/phantoms/phantom.h"
#include "raysweep/sweep/directions.h"

namespace raysweep::test {
namespace {

double channelAt(const openvdb::GridBase& grid, const openvdb::Coord& at, int channel) {
    if (grid.isType<openvdb::FloatGrid>())
        return double(static_cast<const openvdb::FloatGrid&>(grid).tree().getValue(at));
    return double(dynamic_cast<const openvdb::Vec3SGrid&>(grid).tree().getValue(at)[channel]);
}

template <class GridType>
bool sameValues(const GridType& a, const GridType& b) {
    if (a.activeVoxelCount() != b.activeVoxelCount()) return false;
    const auto other = b.getConstAccessor();
    for (auto on = a.cbeginValueOn(); on; ++on) {
        typename GridType::ValueType value;
        const auto here = *on;
        if (!other.probeValue(on.getCoord(), value) || std::memcmp(&value, &here, sizeof value) != 0) return false;
    }
    return true;
}

}  // namespace

openvdb::FloatGrid::Ptr boxVolume(const Index3& size, float density) {
    auto grid = openvdb::FloatGrid::create();
    grid->denseFill({{0, 0, 0}, {size.x - 1, size.y - 1, size.z - 1}}, density);
    return grid;
}

openvdb::FloatGrid::Ptr namedBox(const std::string& name, float value) {
    const openvdb::FloatGrid::Ptr grid = boxVolume(Index3(4), value);
    grid->setName(name);
    return grid;
}

openvdb::FloatGrid::Ptr ballVolume(int edge) {
    auto grid = openvdb::FloatGrid::create();
    auto accessor = grid->getAccessor();
    const double middle = 0.5 * (edge - 1);
    for (int i = 0; i < edge; ++i)
        for (int j = 0; j < edge; ++j)
            for (int k = 0; k < edge; ++k)
                if ((Vec3(i, j, k) - Vec3(middle)).length() <= 0.5 * edge) accessor.setValue({i, j, k}, 1);
    return grid;
}

openvdb::FloatGrid::Ptr cloudVolume(int edge) {
    PhantomOptions options;
    options.size = edge;
    options.voxelSize = 1;
    const auto cloud = makeCloud(options);
    const openvdb::Coord low = cloud->evalActiveVoxelBoundingBox().min();
    auto grid = openvdb::FloatGrid::create();
    auto accessor = grid->getAccessor();
    for (auto on = cloud->cbeginValueOn(); on; ++on) accessor.setValue(on.getCoord() - low, *on);
    return grid;
}

openvdb::FloatGrid::Ptr noiseBall(int radius, double low, double high) {
    auto grid = openvdb::FloatGrid::create();
    auto accessor = grid->getAccessor();
    std::mt19937_64 random(7);
    for (int i = -radius; i <= radius; ++i)
        for (int j = -radius; j <= radius; ++j)
            for (int k = -radius; k <= radius; ++k)
                if (i * i + j * j + k * k <= radius * radius)
                    accessor.setValue({i, j, k}, float(low * std::pow(high / low, uniform01(random))));
    return grid;
}

std::string findData(const std::string& name) {
    const char* const given = std::getenv("RAYSWEEP_DATA");
    const std::string folder = given && *given ? given : sourceFolder() + "/../shared/data";
    return std::filesystem::exists(folder + "/" + name) ? folder + "/" + name : "";
}

Vec3 quarterTurn(const Vec3& v, int axis) {
    const int from = (axis + 1) % 3, to = (axis + 2) % 3;
    Vec3 turned = v;
    turned[to] = v[from];
    turned[from] = -v[to];
    return turned;
}

openvdb::Coord quarterTurn(const openvdb::Coord& v, int axis) {
    const int from = (axis + 1) % 3, to = (axis + 2) % 3;
    openvdb::Coord turned = v;
    turned[std::size_t(to)] = v[std::size_t(from)];
    turned[std::size_t(from)] = -v[std::size_t(to)];
    return turned;
}

openvdb::FloatGrid::Ptr quarterTurned(const openvdb::FloatGrid& grid, int axis) {
    auto turned = openvdb::FloatGrid::create();
    auto accessor = turned->getAccessor();
    for (auto on = grid.cbeginValueOn(); on; ++on) accessor.setValue(quarterTurn(on.getCoord(), axis), *on);
    return turned;
}

DenseVolume dense(const openvdb::GridBase& grid, const openvdb::FloatGrid& shape, int channel) {
    const openvdb::CoordBBox box = shape.evalActiveVoxelBoundingBox();
    const openvdb::Coord size = box.dim();
    DenseVolume result{{box.min().x(), box.min().y(), box.min().z()}, {size.x(), size.y(), size.z()}, {}};
    result.values.assign(std::size_t(box.volume()), 0.0);
    const auto accessor = shape.getConstAccessor();
    for (auto at = box.begin(); at; ++at)
        if (accessor.isValueOn(*at)) {
            const openvdb::Coord i = *at - box.min();
            result.values[std::size_t((i.x() * size.y() + i.y()) * size.z() + i.z())] = channelAt(grid, *at, channel);
        }
    return result;
}

DenseVolume dense(const openvdb::FloatGrid& grid, const openvdb::FloatGrid& shape) {
    return dense(grid, shape, 0);
}

McScene monteCarloScene(const Scene& scene) {
    const openvdb::FloatGrid& density = *scene.medium.density;
    if (scene.suns.size() > 1) throw std::invalid_argument("monteCarloScene: more than one sun");
    const DenseVolume volume = dense(density, density);
    McScene mc;
    mc.nx = volume.size.x, mc.ny = volume.size.y, mc.nz = volume.size.z;
    mc.h = density.voxelSize()[0];
    const openvdb::Vec3d corner = density.indexToWorld(openvdb::Vec3d(volume.low.x, volume.low.y, volume.low.z) - 0.5);
    mc.origin = Vec3(corner.x(), corner.y(), corner.z());
    for (const double value : volume.values) mc.extinction.push_back(value * scene.medium.extinctionScale);
    mc.evenLight = false;
    mc.albedo = {double(scene.medium.albedo.x)};
    if (scene.medium.emission) {
        mc.emission = dense(*scene.medium.emission, density, 0).values;
        for (double& power : mc.emission) power *= scene.medium.emissionScale;
    }
    for (const Sun& sun : scene.suns) mc.sun = McSun{sun.direction, double(sun.irradiance.x)};
    if (scene.sky.radiance.x > 0) mc.sky = McSky{double(scene.sky.radiance.x), {true, true, true, true, true, true}};
    for (const PointLight& point : scene.points) mc.pointLights.push_back({point.position, double(point.power.x)});
    return mc;
}

Departure fromOne(const openvdb::GridBase& radiosity, const openvdb::FloatGrid& density, int channel) {
    double sum = 0, squares = 0;
    std::size_t count = 0;
    for (auto on = density.cbeginValueOn(); on; ++on) {
        if (!(*on > 0)) continue;
        const double value = channelAt(radiosity, on.getCoord(), channel);
        sum += value;
        squares += (value - 1) * (value - 1);
        ++count;
    }
    return {sum / double(count), std::sqrt(squares / double(count))};
}

double relativeDifference(const openvdb::GridBase& a, const openvdb::GridBase& b, const openvdb::FloatGrid& shape) {
    double difference = 0, norm = 0;
    for (auto on = shape.cbeginValueOn(); on; ++on) {
        const double x = channelAt(a, on.getCoord(), 0), y = channelAt(b, on.getCoord(), 0);
        difference += (x - y) * (x - y);
        norm += y * y;
    }
    return std::sqrt(difference / norm);
}

double massOf(const openvdb::FloatGrid& grid) {
    double sum = 0;
    for (auto it = grid.cbeginValueOn(); it; ++it) sum += double(*it) * double(it.getVoxelCount());
    return sum * grid.transform().voxelSize().product();
}

bool sameBits(const openvdb::GridBase& a, const openvdb::GridBase& b) {
    if (a.type() != b.type()) return false;
    if (a.isType<openvdb::FloatGrid>())
        return sameValues(static_cast<const openvdb::FloatGrid&>(a), static_cast<const openvdb::FloatGrid&>(b));
    return sameValues(dynamic_cast<const openvdb::Vec3SGrid&>(a), dynamic_cast<const openvdb::Vec3SGrid&>(b));
}

}  // namespace raysweep::test
