#include "raysweep/formats/nrrd_axes.h"

#include "raysweep/core/error.h"
#include "raysweep/formats/header_lines.h"
#include "raysweep/formats/read_failure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>

namespace raysweep {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

enum class Role { space, volume, channel };

/// One axis as the header has it.
struct Axis {
    std::int64_t size = 0;
    std::string kind, unit;  ///< lower case; empty: not said
    std::optional<std::vector<double>> direction;
    double spacing = kUnknown, min = kUnknown, max = kUnknown;
    bool node = false;  ///< samples are at min and max, not in the middle of cells
    Role role = Role::space;
};

/// A field as text, and where errors say it is.
class Field {
  public:
    Field(const NrrdHeader& header, const std::string& name, const std::string& path)
        : text_(header.of(name)), name_(name), path_(path) {}

    [[noreturn]] void fail(const std::string& why) const {
        failRead(path_, "in its header: " + name_ + " '" + text_.substr(0, 200) + "' " + why);
    }
    const std::string& text() const { return text_; }

    std::vector<std::string> words() const { return wordsOf(text_); }

    /// "mm" "mm" "um", as they stand in quotation marks.
    std::vector<std::string> quoted() const {
        std::vector<std::string> parts;
        for (std::size_t open = text_.find('"'); open != std::string::npos;) {
            const std::size_t close = text_.find('"', open + 1);
            if (close == std::string::npos) fail("lacks a quotation mark");
            parts.push_back(trimmed(text_.substr(open + 1, close - open - 1)));
            open = text_.find('"', close + 1);
        }
        return parts;
    }

    /// "(1,0,0) none (0,1,0)"; nothing for "none".
    std::vector<std::optional<std::vector<double>>> vectors() const {
        std::vector<std::optional<std::vector<double>>> found;
        for (std::size_t at = 0; (at = text_.find_first_not_of(kBlanks, at)) != std::string::npos;) {
            if (text_.compare(at, 4, "none") == 0) {
                found.emplace_back();
                at += 4;
                continue;
            }
            const std::size_t close = text_.find(')', at);
            if (text_[at] != '(' || close == std::string::npos) fail("is no list of vectors");
            std::string inside = text_.substr(at + 1, close - at - 1);
            std::replace(inside.begin(), inside.end(), ',', ' ');
            found.emplace_back(std::vector<double>());
            if (!toNumbers(inside, *found.back())) fail("is no list of vectors");
            at = close + 1;
        }
        return found;
    }

  private:
    std::string text_, name_;
    const std::string& path_;
};

/// Numbers, one per axis, put where `member` says.
void readNumbers(const NrrdHeader& header, const std::string& name, const std::string& path, double Axis::*member,
                 std::vector<Axis>& axes) {
    if (!header.has(name)) return;
    const Field field(header, name, path);
    std::vector<double> numbers;
    if (!toNumbers(field.text(), numbers) || numbers.size() != axes.size()) field.fail("is not one number per axis");
    for (std::size_t n = 0; n < axes.size(); ++n) axes[n].*member = numbers[n];
}

std::vector<std::string> onePerAxis(const Field& field, const std::vector<std::string>& words, std::size_t axes) {
    if (!words.empty() && words.size() != axes) field.fail("does not say as much as there are axes");
    return words;
}

std::vector<Axis> readAxes(const NrrdHeader& header, const std::string& path) {
    constexpr std::int64_t kMost = 16;  // as Teem
    std::int64_t count = 0;
    if (!toWhole(header.of("dimension"), count) || count < 1 || count > kMost)
        failRead(path, "in its header: dimension '" + header.of("dimension") + "' is none from 1 to 16");
    std::vector<Axis> axes{std::size_t(count)};
    const auto field = [&](const char* name) { return Field(header, name, path); };
    std::vector<std::int64_t> sizes;
    if (!toWholes(header.of("sizes"), sizes) || sizes.size() != axes.size() ||
        *std::min_element(sizes.begin(), sizes.end()) < 1)
        field("sizes").fail("is not one number per axis, each larger than 0");
    const auto kinds = onePerAxis(field("kinds"), field("kinds").words(), axes.size());
    const auto centers = onePerAxis(field("centers"), field("centers").words(), axes.size());
    const auto units = onePerAxis(field("units"), field("units").quoted(), axes.size());
    for (std::size_t n = 0; n < axes.size(); ++n) {
        axes[n].size = sizes[n];
        if (!kinds.empty()) axes[n].kind = lowerCase(kinds[n]);
        if (axes[n].kind == "none" || axes[n].kind == "???") axes[n].kind.clear();
        if (!centers.empty()) axes[n].node = lowerCase(centers[n]) == "node";
        if (!units.empty()) axes[n].unit = units[n];
    }
    readNumbers(header, "spacings", path, &Axis::spacing, axes);
    readNumbers(header, "axismins", path, &Axis::min, axes);
    readNumbers(header, "axismaxs", path, &Axis::max, axes);
    if (!header.has("spacedirections")) return axes;
    const auto directions = field("spacedirections").vectors();
    if (directions.size() != axes.size()) field("spacedirections").fail("is not one vector, or none, per axis");
    for (std::size_t n = 0; n < axes.size(); ++n) axes[n].direction = directions[n];
    return axes;
}

/// Axes of space, three at most; the others are volumes or channels by their kinds, by their place where those say
/// nothing: numbers side by side are those of a voxel.
void assignRoles(std::vector<Axis>& axes, bool directed) {
    static const std::set<std::string> kSpatial = {"", "domain", "space"}, kVolumes = {"time", "list"};
    int spatial = 0;
    for (std::size_t n = 0; n < axes.size(); ++n) {
        Axis& axis = axes[n];
        const bool bySpace = kSpatial.count(axis.kind) > 0;
        if (bySpace && (!directed || axis.direction) && ++spatial <= 3) continue;
        axis.role = kVolumes.count(axis.kind) > 0 || (bySpace && n > 0) ? Role::volume : Role::channel;
    }
}

std::function<std::string(int)> namesOf(const std::string& kind) {
    static const std::map<std::string, std::vector<std::string>> kNames = {
        {"rgb-color", {"red", "green", "blue"}},
        {"rgba-color", {"red", "green", "blue", "alpha"}},
        {"hsv-color", {"hue", "saturation", "value"}},
        {"xyz-color", {"X", "Y", "Z"}},
        {"complex", {"real", "imaginary"}},
        {"2-vector", {"x", "y"}},
        {"3-vector", {"x", "y", "z"}},
        {"3d-symmetric-matrix", {"xx", "xy", "xz", "yy", "yz", "zz"}},
        {"3d-masked-symmetric-matrix", {"mask", "xx", "xy", "xz", "yy", "yz", "zz"}}};
    const auto found = kNames.find(kind);
    if (found == kNames.end()) return {};
    return [names = found->second](int n) {
        return std::size_t(n) < names.size() ? names[std::size_t(n)] : std::string("?");
    };
}

/// Sets where along the axes of `role` to read: they count together, the first of them fastest.
void choose(const std::string& path, const VolumeChoice& choice, Role role, const std::vector<Axis>& axes,
            std::vector<DeclaredAxis>& declared) {
    Several several;
    std::string kinds, sizes;
    for (const Axis& axis : axes) {
        if (axis.role == Role::space) sizes += (sizes.empty() ? "" : "x") + std::to_string(axis.size);
        if (axis.role != role) continue;
        several.name = several.count == 1 ? namesOf(axis.kind) : nullptr;
        several.count *= std::uint64_t(axis.size);
        if (several.count > std::uint64_t(std::numeric_limits<std::int32_t>::max()))
            failRead(path, "its header promises more volumes than there can be");
        if (!axis.kind.empty()) kinds += (kinds.empty() ? "" : ", ") + axis.kind;
    }
    several.what =
        (role == Role::channel ? "channels" : "volumes of " + sizes) + (kinds.empty() ? "" : " (kinds: " + kinds + ")");
    std::int64_t chosen =
        role == Role::channel ? chooseChannel(path, several, choice) : chooseVolume(path, several, choice);
    for (std::size_t n = 0; n < axes.size(); ++n) {
        if (axes[n].role != role) continue;
        declared[n].chosen = chosen % axes[n].size;
        chosen /= axes[n].size;
    }
}

/// -1 where an axis of the file's space runs against LPS. Spaces that are no patient's are left as they are.
Vec3 signsOf(const std::string& space) {
    const std::string name = space.substr(0, space.find("-time"));
    if (name == "right-anterior-superior" || name == "ras") return Vec3(-1, -1, 1);
    if (name == "left-anterior-superior" || name == "las") return Vec3(1, -1, 1);
    return Vec3(1, 1, 1);
}

Vec3 turned(const std::vector<double>& vector, const Vec3& signs, const Field& field) {
    Vec3 result(0);
    for (std::size_t n = 0; n < vector.size(); ++n) {
        if (!std::isfinite(vector[n])) field.fail("is not finite");
        if (n < 3) result[int(n)] = vector[n] * signs[int(n)];
    }
    return result;
}

/// How many numbers its vectors have.
std::size_t dimensionOfSpace(const NrrdHeader& header, const std::string& path) {
    static const std::set<std::string> kThree = {"ras",
                                                 "las",
                                                 "lps",
                                                 "right-anterior-superior",
                                                 "left-anterior-superior",
                                                 "left-posterior-superior",
                                                 "scanner-xyz",
                                                 "3d-right-handed",
                                                 "3d-left-handed"};
    static const std::set<std::string> kThreeAndTime = {"rast",
                                                        "last",
                                                        "lpst",
                                                        "right-anterior-superior-time",
                                                        "left-anterior-superior-time",
                                                        "left-posterior-superior-time",
                                                        "scanner-xyz-time",
                                                        "3d-right-handed-time",
                                                        "3d-left-handed-time"};
    const std::string space = lowerCase(header.of("space"));
    std::int64_t dimension = 0;
    if (header.has("space") && header.has("spacedimension")) failRead(path, "its header gives its space twice");
    if (kThree.count(space)) return 3;
    if (kThreeAndTime.count(space)) return 4;
    if (header.has("space")) Field(header, "space", path).fail("is none that NRRD knows");
    if (!header.has("spacedimension")) return 0;
    if (!toWhole(header.of("spacedimension"), dimension) || dimension < 1 || dimension > 8)
        Field(header, "spacedimension", path).fail("is none from 1 to 8");
    return std::size_t(dimension);
}

/// From one sample to the next along an axis that has no direction.
double spacingOf(const Axis& axis, const std::string& path) {
    double spacing = axis.spacing;
    const double intervals = double(axis.node ? axis.size - 1 : axis.size);
    if (std::isnan(spacing) && intervals > 0) spacing = (axis.max - axis.min) / intervals;  // NaN if not said
    if (std::isnan(spacing)) return 1;
    if (!std::isfinite(spacing) || spacing == 0) failRead(path, "in its header: a spacing is 0 or infinite");
    return spacing;
}

void placeAxes(const NrrdHeader& header, const std::string& path, const std::vector<Axis>& axes, NrrdAxes& result) {
    const std::size_t dimension = dimensionOfSpace(header, path);
    std::string space = lowerCase(header.of("space"));
    if (dimension == 4 && !space.empty() && space.size() == 4) space.pop_back();  // rast, last, lpst
    const Vec3 signs = signsOf(space);
    const Field directions(header, "spacedirections", path), origins(header, "spaceorigin", path);
    int n = 0;
    for (const Axis& axis : axes) {
        if (axis.direction && (axis.direction->size() != dimension || dimension == 0))
            directions.fail("has vectors of another length than its space");
        if (axis.role != Role::space) continue;
        if (axis.direction) {
            result.steps[std::size_t(n++)] = turned(*axis.direction, signs, directions);
            continue;
        }
        const double spacing = spacingOf(axis, path);
        result.steps[std::size_t(n)] *= spacing;
        // Where samples are in cells, which Teem takes for granted, the axis begins half a cell before the first.
        if (std::isfinite(axis.min)) result.origin[n] = axis.min + (axis.node ? 0 : 0.5 * spacing);
        ++n;
    }
    if (!origins.text().empty() && lowerCase(origins.text()) != "none") {
        const auto vectors = origins.vectors();
        if (vectors.size() != 1 || !vectors[0] || vectors[0]->size() != dimension)
            origins.fail("is no point of its space");
        result.origin = turned(*vectors[0], signs, origins);
    }
    // Pictures have a third axis across the others.
    const Vec3 across = result.steps[0].cross(result.steps[1]);
    if (n == 2 && across.length() > 0) result.steps[2] = across.normalized();
}

std::string unitOf(const NrrdHeader& header, const std::string& path, const std::vector<Axis>& axes) {
    std::vector<std::string> units = Field(header, "spaceunits", path).quoted();
    if (units.size() > 3) units.resize(3);  // the fourth is time's
    if (units.empty())
        for (const Axis& axis : axes)
            if (axis.role == Role::space && !axis.unit.empty()) units.push_back(axis.unit);
    for (const std::string& unit : units)
        if (unit != units.front())
            throw InvalidArgument("'" + path + "' has places in '" + units.front() + "' along one axis and in '" +
                                  unit + "' along another; save it in one unit");
    return units.empty() ? "" : units.front();
}

}  // namespace

NrrdAxes nrrdAxes(const NrrdHeader& header, const std::string& path, const VolumeChoice& choice) {
    std::vector<Axis> axes = readAxes(header, path);
    assignRoles(axes, header.has("spacedirections"));
    NrrdAxes result;
    result.steps = {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
    for (const Axis& axis : axes) result.axes.push_back({axis.size, axis.role == Role::space});
    choose(path, choice, Role::channel, axes, result.axes);
    choose(path, choice, Role::volume, axes, result.axes);
    placeAxes(header, path, axes, result);
    result.unit = unitOf(header, path, axes);
    return result;
}

}  // namespace raysweep
