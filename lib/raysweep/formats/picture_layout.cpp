// Sources: ImageJ, ij.io.FileInfo and TiffDecoder; the OME data model, 2016-06.
#include "raysweep/formats/picture_layout.h"

#include "raysweep/core/error.h"
#include "raysweep/formats/header_lines.h"
#include "raysweep/formats/read_failure.h"

#include <pugixml.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <sstream>

namespace raysweep {
namespace {

constexpr int kMostPages = 1 << 20;

/// "key=value" lines.
std::map<std::string, std::string> linesOf(const std::string& description) {
    std::map<std::string, std::string> lines;
    std::istringstream in(description);
    for (std::string line; std::getline(in, line);) {
        const std::size_t equals = line.find('=');
        if (equals != std::string::npos)
            lines.emplace(trimmed(line.substr(0, equals)), trimmed(line.substr(equals + 1)));
    }
    return lines;
}

/// `raysweep_place` of tiff_write.cpp.
StoredPlace placeOf(const std::string& path, const std::string& text) {
    constexpr double kMost = 1e30;
    std::vector<double> numbers;
    const bool known = toNumbers(text, numbers) && numbers.size() == 12 &&
                       std::all_of(numbers.begin(), numbers.end(), [](double n) { return std::abs(n) <= kMost; });
    if (!known) failRead(path, "in its description: raysweep_place '" + text.substr(0, 200) + "' is not 12 numbers");
    const auto vector = [&](std::size_t n) { return Vec3(numbers[3 * n], numbers[3 * n + 1], numbers[3 * n + 2]); };
    return {vector(0), {vector(1), vector(2), vector(3)}};
}

PictureLayout layoutOfImageJ(const std::string& path, const std::string& description, double columnsPerUnit,
                             double rowsPerUnit) {
    const auto lines = linesOf(description);
    const auto number = [&](const std::string& key, double otherwise) {
        const auto found = lines.find(key);
        double value = otherwise;
        if (found != lines.end() && !(toNumber(found->second, value) && std::isfinite(value)))
            failRead(path, "in ImageJ's description: " + key + " '" + found->second.substr(0, 60) + "' is no number");
        return value;
    };
    const auto count = [&](const std::string& key, double otherwise) {
        const double value = number(key, otherwise);
        if (!(value >= 1 && value <= kMostPages)) failRead(path, "in ImageJ's description: " + key + " makes no sense");
        return int(value);
    };
    PictureLayout layout;
    layout.known = true;
    layout.program = "ImageJ";
    const int images = count("images", 1);
    layout.channels = count("channels", 1);
    layout.frames = count("frames", 1);
    layout.slices = count("slices", std::max(1.0, double(images) / layout.channels / layout.frames));
    constexpr double kStraight = 0, kNone = 20;
    const double function = number("cf", lines.count("c1") ? kStraight : kNone);
    if (function == kStraight) {
        layout.rescaling.intercept = number("c0", 0);
        layout.rescaling.slope = number("c1", 1);
    } else if (function != kNone) {
        throw InvalidArgument("'" + path + "' has a calibration that is no straight line (ImageJ's function " +
                              lines.at("cf").substr(0, 60) + "); apply it in ImageJ first");
    }
    const auto place = lines.find("raysweep_place"), unit = lines.find("unit");
    if (place != lines.end()) {
        layout.place = placeOf(path, place->second);
        return layout;
    }
    if (unit == lines.end() || unit->second == "pixel" || unit->second == "pixels") return layout;
    layout.unit = unit->second == "\\u00B5m" || unit->second == "micron" ? "um" : unit->second;
    layout.spacing = Vec3(columnsPerUnit > 0 ? 1 / columnsPerUnit : 1, rowsPerUnit > 0 ? 1 / rowsPerUnit : 1,
                          std::abs(number("spacing", 1)));
    return layout;
}

/// Before any page is counted.
void requireFewPages(const std::string& path, const PictureLayout& layout) {
    if (double(layout.channels) * layout.slices * layout.frames > kMostPages)
        failRead(path, layout.program + " promises more pages than there can be");
}

/// Pages must be in the order that DimensionOrder says, in this file.
void requirePlainOrder(const std::string& path, const pugi::xml_node& pixels, const PictureLayout& layout) {
    const auto refuse = [&](const std::string& why) {
        throw InvalidArgument("'" + path + "' is OME-TIFF " + why + "; save it as one plain stack first");
    };
    for (const pugi::xml_node data : pixels.children("TiffData")) {
        const std::string file = data.child("UUID").attribute("FileName").value();
        if (!file.empty() && file != path.substr(path.find_last_of('/') + 1))
            refuse("whose pages are in other files, too");
        if (!data.attribute("IFD")) continue;
        const int c = data.attribute("FirstC").as_int(), z = data.attribute("FirstZ").as_int(),
                  t = data.attribute("FirstT").as_int();
        const bool within = c >= 0 && c < layout.channels && z >= 0 && z < layout.slices && t >= 0 && t < layout.frames;
        if (!within || data.attribute("IFD").as_int() != layout.page(c, z, t))
            refuse("whose pages are in an order of their own");
    }
}

PictureLayout layoutOfOme(const std::string& path, const std::string& description) {
    pugi::xml_document document;
    if (!document.load_buffer(description.data(), description.size())) failRead(path, "its OME-XML is malformed");
    const pugi::xml_node ome = document.document_element();
    const auto images = ome.children("Image");
    const auto count = std::distance(images.begin(), images.end());
    if (count > 1)
        throw InvalidArgument("'" + path + "' holds " + std::to_string(count) +
                              " OME images; save the one that is wanted in a file of its own");
    const pugi::xml_node pixels = ome.child("Image").child("Pixels");
    PictureLayout layout;
    if (!pixels) return layout;
    layout.known = true;
    layout.program = "OME-XML";
    const auto size = [&](const char* name) {
        const int value = pixels.attribute(name).as_int(1);
        if (value < 1 || value > kMostPages) failRead(path, std::string("in its OME-XML: ") + name + " makes no sense");
        return value;
    };
    layout.channels = size("SizeC");
    layout.slices = size("SizeZ");
    layout.frames = size("SizeT");
    const std::string order = pixels.attribute("DimensionOrder").as_string("XYCZT");
    std::string sorted = order;
    std::sort(sorted.begin(), sorted.end());
    if (sorted != "CTXYZ" || order.substr(0, 2) != "XY")
        failRead(path, "in its OME-XML: DimensionOrder makes no sense");
    layout.order = order.substr(2);
    int samples = 1;  // channels side by side in one page
    for (const pugi::xml_node channel : pixels.children("Channel")) {
        samples = std::max(samples, channel.attribute("SamplesPerPixel").as_int(1));
        layout.channelNames.push_back(channel.attribute("Name").value());
    }
    if (samples > 1 && layout.channels % samples == 0) layout.channels /= samples;
    requireFewPages(path, layout);
    requirePlainOrder(path, pixels, layout);
    const char* const kAxes[] = {"X", "Y", "Z"};
    for (int axis = 0; axis < 3; ++axis) {
        const std::string name = std::string("PhysicalSize") + kAxes[axis];
        if (!pixels.attribute(name.c_str())) continue;
        const double value = pixels.attribute(name.c_str()).as_double();
        std::string unit = pixels.attribute((name + "Unit").c_str()).as_string("um");
        if (unit == "\xC2\xB5m" || unit == "\xCE\xBCm") unit = "um";
        if (!(value > 0) || !std::isfinite(value)) failRead(path, "in its OME-XML: " + name + " makes no sense");
        if (!layout.unit.empty() && layout.unit != unit)
            throw InvalidArgument("'" + path + "' has its physical sizes in '" + layout.unit + "' and in '" + unit +
                                  "'");
        layout.unit = unit;
        layout.spacing[axis] = value;
    }
    return layout;
}

}  // namespace

int PictureLayout::page(int channel, int slice, int frame) const {
    int page = 0, stride = 1;
    for (const char axis : order) {
        page += stride * (axis == 'C' ? channel : axis == 'Z' ? slice : frame);
        stride *= axis == 'C' ? channels : axis == 'Z' ? slices : frames;
    }
    return page;
}

PictureLayout pictureLayout(const std::string& path, const std::string& description, double columnsPerUnit,
                            double rowsPerUnit) {
    PictureLayout layout;
    if (description.rfind("ImageJ=", 0) == 0)
        layout = layoutOfImageJ(path, description, columnsPerUnit, rowsPerUnit);
    else if (description.find("<OME") != std::string::npos)
        layout = layoutOfOme(path, description);
    requireFewPages(path, layout);
    return layout;
}

}  // namespace raysweep
