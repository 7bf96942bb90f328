#include "raysweep/reconstruct/photo_views.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

/// What a ray stands for, if there are `parts` x `parts` for each pixel.
RayShare shareOf(const PhotoCamera& camera, const Ray& ray, const CompositeRay& line, const ReconstructionGrid& grid,
                 double parts) {
    const double perPixel = std::sqrt(double(line.length)) / (parts * grid.edge());
    if (camera.projection == Camera::Projection::Orthographic)
        return {float(perPixel / std::sqrt(camera.focalX * camera.focalY)), 0};
    // A pixel's cross section grows with the square of the depth, and is smaller for rays that are aslant.
    const double aslant = ray.direction.dot(camera.forward);
    const double perDepth = perPixel * std::sqrt(aslant / (camera.focalX * camera.focalY));
    const double slice = line.start + (grid.voxel(0, 0, 0)[line.axis] - ray.origin[line.axis]) / grid.edge();
    const double along = ray.direction[line.axis];
    const double depth = (slice * grid.edge() / along) * aslant, step = line.step * grid.edge() / along * aslant;
    return {float(depth * perDepth), float(step * perDepth)};
}

/// Between the middles of pixels by linear interpolation.
std::array<float, 4> pixelAt(const Image& image, double x, double y) {
    const double left = std::clamp(x - 0.5, 0.0, image.width - 1.0), top = std::clamp(y - 0.5, 0.0, image.height - 1.0);
    const int x0 = int(left), y0 = int(top), x1 = std::min(x0 + 1, image.width - 1);
    const int y1 = std::min(y0 + 1, image.height - 1);
    const float u = float(left - x0), v = float(top - y0);
    std::array<float, 4> pixel;
    for (int c = 0; c < 4; ++c) {
        const float upper = image.at(x0, y0)[c] * (1 - u) + image.at(x1, y0)[c] * u;
        const float lower = image.at(x0, y1)[c] * (1 - u) + image.at(x1, y1)[c] * u;
        pixel[std::size_t(c)] = upper * (1 - v) + lower * v;
    }
    return pixel;
}

double squareOf(const std::array<float, 4>& pixel) {
    double sum = 0;
    for (const float value : pixel) sum += double(value) * value;
    return sum;
}

/// From ray to ray, in voxels: a little more than one does no harm, and more rays know no more.
constexpr double kLargestEdge = 1.25, kLargestHalf = 1.1;
/// Of a square: what pixels are apart if only every other one is taken, as the black fields of a board.
const double kDiagonal = std::sqrt(2.0);

constexpr int kTile = 16;  ///< rays: what a tile's see of a volume stays in the second cache

/// Room for the rays of a square of pixels.
struct Tile {
    std::vector<CompositeRay> rays;
    std::vector<RayShare> shares;
    std::vector<std::array<float, 4>> pixels;
    double missed = 0;
};

/// All tiles' rays, in the order of their axes.
void gather(const std::vector<Tile>& tiles, PhotoRays& to) {
    to.rays.clear();
    to.shares.clear();
    to.pixels.clear();
    to.missed = 0;
    for (const Tile& tile : tiles) to.missed += tile.missed;
    for (int axis = 0; axis < 3; ++axis)
        for (const Tile& tile : tiles)
            for (std::size_t i = 0; i < tile.rays.size(); ++i) {
                if (tile.rays[i].axis != axis) continue;
                to.rays.push_back(tile.rays[i]);
                to.shares.push_back(tile.shares[i]);
                to.pixels.push_back(tile.pixels[i]);
            }
}

}  // namespace

ReconstructionGrid photoGrid(const Box3& box, int resolution) {
    ReconstructionGrid grid;
    const Vec3 size = box.size();
    grid.spacing = Vec3(std::max({size.x, size.y, size.z}) / resolution);
    grid.center = box.center();
    for (int axis = 0; axis < 3; ++axis)
        grid.dims[axis] = std::clamp(int(std::ceil(size[axis] / grid.edge() / 8 - 1e-6)) * 8, 8, resolution);
    return grid;
}

double pixelEdge(const PhotoCamera& camera, const ReconstructionGrid& grid) {
    const double focal = std::sqrt(camera.focalX * camera.focalY);
    if (camera.projection == Camera::Projection::Orthographic) return 1 / (focal * grid.edge());
    const double depth = (grid.center - camera.position).dot(camera.forward);
    return std::max(depth, grid.edge()) / (focal * grid.edge());
}

std::vector<Photograph> picturesFor(const std::vector<Photograph>& photographs, const ReconstructionGrid& grid) {
    requireUsable(photographs);
    std::vector<Photograph> all(photographs.size());
    parallelFor(all.size(), [&](std::size_t n) {
        const Photograph& from = photographs[n];
        const int smaller = std::min(from.matte.width, from.matte.height);
        const int factor = std::clamp(int(1 / pixelEdge(from.camera, grid)), 1, smaller);
        all[n] = factor > 1 ? reduced(from, factor) : from;
    });
    return all;
}

void setRays(PhotoRays& to, const Photograph& picture, const ReconstructionGrid& grid, const CompositeLayout& layout,
             int perSlice, int time) {
    const PhotoCamera& camera = picture.camera;
    const double edge = pixelEdge(camera, grid);
    const int parts = std::max(1, int(std::ceil(edge / kLargestEdge)));
    const bool half = edge * kDiagonal <= kLargestHalf;
    const int width = camera.width * parts, height = camera.height * parts;
    const int tilesAcross = (width + kTile - 1) / kTile, tilesDown = (height + kTile - 1) / kTile;
    std::vector<Tile> tiles(std::size_t(tilesAcross) * std::size_t(tilesDown));
    const Vec3 first = grid.voxel(0, 0, 0);
    parallelFor(tiles.size(), [&](std::size_t n) {
        const int left = int(n) % tilesAcross * kTile, top = int(n) / tilesAcross * kTile;
        for (int y = top; y < std::min(top + kTile, height); ++y)
            for (int x = left; x < std::min(left + kTile, width); ++x) {
                if (half && ((x + y + time) & 1) != 0) continue;
                const Ray ray = pixelRay(camera, (x + 0.5) / parts, (y + 0.5) / parts);
                const CompositeRay line =
                    compositeRay(layout, {(ray.origin - first) / grid.edge(), ray.direction}, perSlice);
                const std::array<float, 4> pixel = pixelAt(picture.matte, (x + 0.5) / parts, (y + 0.5) / parts);
                if (meetsBricks(layout, line)) {
                    tiles[n].rays.push_back(line);
                    tiles[n].shares.push_back(shareOf(camera, ray, line, grid, half ? 1 / kDiagonal : parts));
                    tiles[n].pixels.push_back(pixel);
                } else {
                    tiles[n].missed += squareOf(pixel);
                }
            }
    });
    gather(tiles, to);
    to.pictureRays = double(width) * height / (half ? 2 : 1);
}

void shareColors(const RayShare& share, const RaySamples& s, SampleShare* shares) {
    float squares = 1e-4f;  // what hardly shows has hardly a colour
    for (std::size_t i = 0; i < s.count; ++i) {
        const float seen = s.transmittances[i] - s.transmittances[i + 1];
        squares += seen * seen;
    }
    const float part = 1 / squares;
    for (std::size_t i = 0; i < s.count; ++i)
        shares[i] = {0, share.at(s.numbers[i]) * (s.transmittances[i] - s.transmittances[i + 1]) * part};
}

}  // namespace raysweep
