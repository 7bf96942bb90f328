#include "raysweep/core/brief.h"
#include "raysweep/formats/sections.h"
#include "raysweep/image/image_io.h"
#include "raysweep/image/pixel_text.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

// Pixels.
constexpr int kMargin = 12, kLine = kTextHeight + 5, kGap = 24;
constexpr double kWide = 900, kWidest = 4096;

// As a display shows them: black is for voxels.
const float kGround = linearFromSrgb(0.16f), kInk = linearFromSrgb(0.85f);

/// A section in the picture: its pixels, and what stands above.
struct Panel {
    SectionAxes axes;
    int left = 0, top = 0, width = 0, height = 0;
    std::string title;
};

/// Pixels per world unit: whole pixels for the shortest edge of a voxel where there is room.
double scaleOf(const DenseLayout& layout) {
    const Vec3 spacing = layout.spacing();
    double width = 0, height = 0;
    for (const SectionAxes& axes : kSectionAxes) {
        width += layout.dims[axes.right] * spacing[axes.right];
        height = std::max(height, layout.dims[axes.up] * spacing[axes.up]);
    }
    const double edge = std::min({spacing.x, spacing.y, spacing.z});
    const double wanted = std::ceil(std::max(1.0, kWide / width * edge)) / edge;
    return std::min(wanted, kWidest / std::max(width, height));
}

/// "z = 12.5", or "k = 7" where the grid is turned in the world.
std::string titleOf(const Sections& sections, int normal) {
    const DenseLayout& layout = sections.layout;
    const std::string name = axisName(layout, normal);
    const std::size_t world = std::string("xyz").find(name.back());
    if (world == std::string::npos) return name + " = " + std::to_string(sections.corner[normal] + sections.at[normal]);
    const Vec3 at = layout.origin + layout.steps[std::size_t(normal)] * double(sections.at[normal]);
    return name.substr(name.size() - 1) + " = " + brief(at[int(world)], 5);
}

std::vector<Panel> panelsOf(const Sections& sections, double scale) {
    const Vec3 spacing = sections.layout.spacing();
    const auto pixels = [&](int axis) {
        return std::max(1, int(std::lround(sections.layout.dims[axis] * spacing[axis] * scale)));
    };
    std::vector<Panel> panels;
    int left = kMargin, height = 0;
    for (const SectionAxes& axes : kSectionAxes) {
        left += textWidth(axisName(sections.layout, axes.up)) + kLetterWidth;
        panels.push_back(
            {axes, left, kMargin + kLine, pixels(axes.right), pixels(axes.up), titleOf(sections, axes.normal)});
        left += std::max(panels.back().width, textWidth(panels.back().title)) + kGap;
        height = std::max(height, panels.back().height);
    }
    for (Panel& panel : panels) panel.top += height - panel.height;  // on one line below
    return panels;
}

/// Nearest voxels.
void drawSection(const Sections& sections, std::size_t n, const Panel& panel, Image& image) {
    const int columns = sections.layout.dims[panel.axes.right], rows = sections.layout.dims[panel.axes.up];
    const GreyWindow& window = sections.window;
    const double range = window.high > window.low ? window.high - window.low : 1;
    const auto voxel = [](int pixel, int pixels, int voxels) {
        return std::min(voxels - 1, int((pixel + 0.5) / pixels * voxels));
    };
    for (int y = 0; y < panel.height; ++y)
        for (int x = 0; x < panel.width; ++x) {
            const int row = rows - 1 - voxel(y, panel.height, rows), column = voxel(x, panel.width, columns);
            const float value = sections.planes[n][std::size_t(row) * std::size_t(columns) + std::size_t(column)];
            const double grey = std::clamp((double(value) - window.low) / range, 0.0, 1.0);
            std::fill_n(image.at(panel.left + x, panel.top + y), 3, linearFromSrgb(float(grey)));
        }
}

void fill(Image& image, int left, int top, int width, int height, float light) {
    for (int y = std::max(0, top); y < std::min(image.height, top + height); ++y)
        for (int x = std::max(0, left); x < std::min(image.width, left + width); ++x)
            std::fill_n(image.at(x, y), 3, light);
}

/// Around a section, outside: its axes, and marks where the other two go through.
void drawFrame(const Sections& sections, const Panel& panel, Image& image) {
    constexpr int kMark = 5;
    const DenseLayout& layout = sections.layout;
    const auto place = [&](int axis, int pixels) {
        return int((sections.at[axis] + 0.5) / layout.dims[axis] * pixels);
    };
    const int x = panel.left + place(panel.axes.right, panel.width);
    const int y = panel.top + panel.height - 1 - place(panel.axes.up, panel.height);
    const int right = panel.left + panel.width, bottom = panel.top + panel.height;
    for (const int top : {panel.top - kMark - 1, bottom + 1}) fill(image, x, top, 1, kMark, kInk);
    for (const int left : {panel.left - kMark - 1, right + 1}) fill(image, left, y, kMark, 1, kInk);
    drawText(image, panel.left, panel.top - kLine - 2, panel.title, kInk);
    const std::string up = axisName(layout, panel.axes.up), along = axisName(layout, panel.axes.right);
    drawText(image, panel.left - textWidth(up) - kLetterWidth, panel.top, up, kInk);
    drawText(image, std::max(panel.left, right - textWidth(along)), bottom + 3, along, kInk);
}

/// The bar with its length, and greys from one end of the window to the other.
int drawLegend(const Sections& sections, double scale, int left, int top, Image* image) {
    constexpr int kRamp = 128, kThick = 4;
    constexpr double kLongest = 200;
    const double length = scaleLength(kLongest / scale);
    const int bar = std::max(1, int(std::lround(length * scale)));
    const std::string text = brief(length, 6) + (length == 1 ? " unit" : " units"), low = brief(sections.window.low, 4),
                      high = brief(sections.window.high, 4);
    const int textLeft = left + bar + kLetterWidth, lowLeft = textLeft + textWidth(text) + kGap;
    const int rampLeft = lowLeft + textWidth(low) + kLetterWidth, highLeft = rampLeft + kRamp + kLetterWidth;
    if (image) {
        fill(*image, left, top + (kTextHeight - kThick) / 2, bar, kThick, kInk);
        drawText(*image, textLeft, top, text, kInk);
        drawText(*image, lowLeft, top, low, kInk);
        for (int x = 0; x < kRamp; ++x)
            fill(*image, rampLeft + x, top, 1, kTextHeight, linearFromSrgb(float(x) / (kRamp - 1)));
        drawText(*image, highLeft, top, high, kInk);
    }
    return highLeft + textWidth(high);
}

std::string footnoteOf(const Sections& sections) {
    const Index3 voxel = sections.corner + sections.at;
    return "voxel " + std::to_string(voxel.x) + ", " + std::to_string(voxel.y) + ", " + std::to_string(voxel.z) +
           (hasRightAngles(sections.layout) ? "" : "; axes are sheared, which is not shown");
}

}  // namespace

Image sectionPicture(const Sections& sections) {
    const double scale = scaleOf(sections.layout);
    const std::vector<Panel> panels = panelsOf(sections, scale);
    const Panel& last = panels.back();
    const std::string footnote = footnoteOf(sections);
    const int legendTop = last.top + last.height + 3 + kLine + kMargin;
    const int width = std::max({last.left + std::max(last.width, textWidth(last.title)),
                                drawLegend(sections, scale, kMargin, 0, nullptr), kMargin + textWidth(footnote)});
    Image image(width + kMargin, legendTop + 2 * kLine + kMargin, 3);
    std::fill(image.pixels.begin(), image.pixels.end(), kGround);
    for (std::size_t n = 0; n < panels.size(); ++n) {
        drawSection(sections, n, panels[n], image);
        drawFrame(sections, panels[n], image);
    }
    drawLegend(sections, scale, kMargin, legendTop, &image);
    drawText(image, kMargin, legendTop + kLine, footnote, kInk);
    return image;
}

}  // namespace raysweep
