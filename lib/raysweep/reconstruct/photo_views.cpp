#include "raysweep/reconstruct/photo_views.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

/// Edge of a pixel, seen in the middle of the grid, in voxels.
double pixelEdge(const PhotoCamera& camera, const ReconstructionGrid& grid) {
    const double focal = std::sqrt(camera.focalX * camera.focalY);
    if (camera.projection == Camera::Projection::Orthographic) return 1 / (focal * grid.spacing);
    const double depth = (grid.center - camera.position).dot(camera.forward);
    return std::max(depth, grid.spacing) / (focal * grid.spacing);
}

/// Means of `factor` x `factor` pixels.
Photograph reduced(const Photograph& photograph, int factor) {
    const Image& from = photograph.matte;
    Photograph to{photograph.name, resized(photograph.camera, from.width / factor, from.height / factor), {}};
    to.matte = Image(from.width / factor, from.height / factor, 4);
    const float part = 1.0f / float(factor * factor);
    for (int y = 0; y < to.matte.height; ++y)
        for (int x = 0; x < to.matte.width; ++x)
            for (int i = 0; i < factor * factor; ++i)
                for (int c = 0; c < 4; ++c)
                    to.matte.at(x, y)[c] += part * from.at(x * factor + i % factor, y * factor + i / factor)[c];
    return to;
}

void requireUsable(const std::vector<Photograph>& photographs) {
    if (photographs.empty()) throw InvalidArgument("no photographs");
    for (const Photograph& photograph : photographs) {
        photograph.camera.validate();
        if (photograph.matte.channels != 4)
            throw InvalidArgument(photograph.name + " has no alpha; free it of its backdrop first");
        if (photograph.camera.width != photograph.matte.width || photograph.camera.height != photograph.matte.height)
            throw InvalidArgument(photograph.name + " is not of the size that its camera has");
    }
}

/// What a ray through a pixel of `parts` x `parts` rays stands for.
RayShare shareOf(const PhotoCamera& camera, const Ray& ray, const CompositeRay& line, const ReconstructionGrid& grid,
                 int parts) {
    const double perPixel = std::sqrt(double(line.length)) / (parts * grid.spacing);
    if (camera.projection == Camera::Projection::Orthographic)
        return {float(perPixel / std::sqrt(camera.focalX * camera.focalY)), 0};
    // A pixel's cross section grows with the square of the depth, and is smaller for rays that are aslant.
    const double aslant = ray.direction.dot(camera.forward);
    const double perDepth = perPixel * std::sqrt(aslant / (camera.focalX * camera.focalY));
    const double slice = line.start + (grid.voxel(0, 0, 0)[line.axis] - ray.origin[line.axis]) / grid.spacing;
    const double along = ray.direction[line.axis];
    const double depth = (slice * grid.spacing / along) * aslant, step = line.step * grid.spacing / along * aslant;
    return {float(depth * perDepth), float(step * perDepth)};
}

double squareOf(const float* pixel) {
    double sum = 0;
    for (int c = 0; c < 4; ++c) sum += double(pixel[c]) * pixel[c];
    return sum;
}

/// Room for the rays of a row of pixels.
struct Row {
    std::vector<CompositeRay> rays;
    std::vector<RayShare> shares;
    std::vector<int> columns;
    double missed = 0;
};

}  // namespace

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
             int perSlice) {
    const PhotoCamera& camera = picture.camera;
    // A little larger than a voxel does no harm.
    const int parts = std::max(1, int(std::ceil(pixelEdge(camera, grid) - 0.25)));
    std::vector<Row> rows(std::size_t(camera.height) * std::size_t(parts));
    const Vec3 first = grid.voxel(0, 0, 0);
    parallelFor(rows.size(), [&](std::size_t y) {
        Row& row = rows[y];
        for (int x = 0; x < camera.width * parts; ++x) {
            const Ray ray = pixelRay(camera, (x + 0.5) / parts, (double(y) + 0.5) / parts);
            const CompositeRay line =
                compositeRay(layout, {(ray.origin - first) / grid.spacing, ray.direction}, perSlice);
            if (!meetsBricks(layout, line)) {
                row.missed += squareOf(picture.matte.at(x / parts, int(y) / parts));
                continue;
            }
            row.rays.push_back(line);
            row.shares.push_back(shareOf(camera, ray, line, grid, parts));
            row.columns.push_back(x / parts);
        }
    });
    to.rays.clear();
    to.shares.clear();
    to.pixels.clear();
    to.pictureRays = double(camera.width) * camera.height * parts * parts;
    to.missed = 0;
    for (const Row& row : rows) to.missed += row.missed;
    for (int axis = 0; axis < 3; ++axis)
        for (std::size_t y = 0; y < rows.size(); ++y)
            for (std::size_t i = 0; i < rows[y].rays.size(); ++i) {
                if (rows[y].rays[i].axis != axis) continue;
                const float* pixel = picture.matte.at(rows[y].columns[i], int(y) / parts);
                to.rays.push_back(rows[y].rays[i]);
                to.shares.push_back(rows[y].shares[i]);
                to.pixels.push_back({pixel[0], pixel[1], pixel[2], pixel[3]});
            }
}

Vec3 lightBeside(const PhotoCamera& camera, const PhotoCamera& first, const Vec3& light) {
    return camera.right * light.dot(first.right) + camera.down * light.dot(first.down) +
           camera.forward * light.dot(first.forward);
}

}  // namespace raysweep
