// Pictures of a ball whose rays are known in closed form, from all around, and a small fit of them.
#pragma once

#include "raysweep/camera/photographs.h"
#include "raysweep/reconstruct/photo_fit.h"

#include <cmath>
#include <vector>

namespace raysweep::test {

/// What a ray has of a ball around `center`.
inline double chordOf(const Ray& ray, const Vec3& center, double radius) {
    const Vec3 from = ray.origin - center;
    const double b = from.dot(ray.direction), inside = b * b - (from.dot(from) - radius * radius);
    return inside > 0 ? 2 * std::sqrt(inside) : 0;
}

/// Pixels are means of 3x3 rays. @param alphaOf of a ray @param colorOf of a ray, straight: something with three values
template <class AlphaOf, class ColorOf>
Photograph ballPicture(const Camera& camera, const AlphaOf& alphaOf, const ColorOf& colorOf) {
    Photograph photograph{"ball", photoCamera(camera), Image(camera.width, camera.height, 4)};
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x)
            for (int i = 0; i < 9; ++i) {
                const Ray ray = pixelRay(photograph.camera, x + (i % 3 + 0.5) / 3, y + (i / 3 + 0.5) / 3);
                const float alpha = float(alphaOf(ray)) / 9;
                const auto color = colorOf(ray);
                float* pixel = photograph.matte.at(x, y);
                for (std::size_t c = 0; c < 3; ++c) pixel[c] += alpha * float(color[c]);
                pixel[3] += alpha;
            }
    return photograph;
}

/// Evenly around the origin (a Fibonacci lattice), at distance 3. @param turn about z, radians
inline std::vector<Vec3> placesAround(int count, double turn = 0) {
    std::vector<Vec3> places;
    for (int n = 0; n < count; ++n) {
        const double z = 1 - (2 * n + 1.0) / count, r = std::sqrt(1 - z * z), angle = 2.399963 * n + turn;
        places.push_back(Vec3(r * std::cos(angle), r * std::sin(angle), z) * 3.0);
    }
    return places;
}

/// In a grid of 16 voxels along an edge.
inline PhotoFitOptions smallFit() {
    PhotoFitOptions options;
    options.resolution = 16;
    options.levels = 1;
    options.passes = 30;
    options.raysPerUpdate = 2048;
    options.box = Box3(Vec3(-1), Vec3(1));
    return options;
}

}  // namespace raysweep::test
