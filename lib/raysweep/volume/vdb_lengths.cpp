// The layout is that of OpenVDB 10: io/Archive.cc (readHeader), MetaMap.cc (readMeta), io/GridDescriptor.cc (read).
#include "raysweep/volume/vdb_lengths.h"

#include "raysweep/core/error.h"

#include <openvdb/io/GridDescriptor.h>
#include <openvdb/math/Transform.h>
#include <openvdb/version.h>

#include <algorithm>
#include <map>

namespace raysweep {
namespace {

/// Values whose size does not hang on what is said of it: OpenVDB reads these many bytes of them.
const std::map<std::string, std::uint32_t> kFixedSizes = {{"bool", 1},   {"int32", 4},  {"int64", 8},  {"float", 4},
                                                          {"double", 8}, {"vec2i", 8},  {"vec2s", 8},  {"vec2d", 16},
                                                          {"vec3i", 12}, {"vec3s", 12}, {"vec3d", 24}, {"vec4i", 16},
                                                          {"vec4s", 16}, {"vec4d", 32}, {"mat4s", 64}, {"mat4d", 128}};

/// Walks over what is read; the position is put back at the end.
class Lengths {
  public:
    Lengths(std::istream& in, std::uintmax_t size) : in_(in), size_(std::streamoff(size)), start_(in.tellg()) {}
    ~Lengths() {
        try {
            in_.clear();
            in_.seekg(start_);
        } catch (const std::ios_base::failure&) {  // then what reads next says so
        }
    }

    template <class Number>
    Number number() {
        Number value{};
        in_.read(reinterpret_cast<char*>(&value), sizeof value);
        return value;
    }

    void skip(std::uint64_t bytes) {
        const std::streamoff left = size_ - std::streamoff(in_.tellg());
        if (left < 0 || bytes > std::uint64_t(left))
            throw IoError("it says of something that it is " + std::to_string(bytes) + " bytes long, but only " +
                          std::to_string(left < 0 ? 0 : left) + " follow; the file is damaged or truncated");
        in_.seekg(std::streamoff(bytes), std::ios::cur);
    }

    std::string text() {
        const auto length = number<std::uint32_t>();
        const std::streampos begin = in_.tellg();
        skip(length);
        constexpr std::uint32_t kShown = 256;  // names of types are shorter
        std::string start(std::min(length, kShown), '\0');
        in_.seekg(begin);
        in_.read(&start[0], std::streamsize(start.size()));
        in_.seekg(begin + std::streamoff(length));
        return start;
    }

    void metadata() {
        const auto count = number<std::uint32_t>();
        for (std::uint32_t n = 0; n < count; ++n) {
            text();
            const auto fixed = kFixedSizes.find(text());
            const auto length = number<std::uint32_t>();
            if (fixed != kFixedSizes.end() && fixed->second != length)
                throw IoError("a value of type " + fixed->first + " is said to be " + std::to_string(length) +
                              " bytes long; the file is damaged");
            skip(length);
        }
    }

    void transform(std::uint32_t version) {
        const std::streampos begin = in_.tellg();
        if (text() == openvdb::math::NonlinearFrustumMap::mapType()) {
            const bool floats = version >= openvdb::OPENVDB_FILE_VERSION_FLOAT_FRUSTUM_BBOX;
            skip(6 * (floats ? sizeof(double) : sizeof(std::int32_t)) + 2 * sizeof(double));  // box, taper, depth
            text();                                                                           // type of the map in it
        }
        in_.seekg(begin);
        try {
            openvdb::math::Transform().read(in_);
        } catch (const openvdb::Exception& e) {
            throw IoError(std::string("its transform cannot be read: ") + e.what() + "; the file is damaged");
        }
    }

    void requireZeroBackground() {
        skip(sizeof(std::uint32_t));  // number of buffers
        if (number<std::uint32_t>() != 0) throw IoError("it has points where there can be none; the file is damaged");
    }

  private:
    std::istream& in_;
    std::streamoff size_;
    std::streampos start_;
};

}  // namespace

void requireHeaderLengths(std::istream& in, std::uintmax_t size) {
    using namespace openvdb;
    constexpr std::uint64_t kTextualId = 36, kBinaryId = 16;
    Lengths lengths(in, size);
    lengths.number<Int64>();  // the magic number
    const auto version = lengths.number<std::uint32_t>();
    if (version < OPENVDB_FILE_VERSION_ROOTNODE_MAP || version > OPENVDB_FILE_VERSION)
        throw IoError("its format has the version " + std::to_string(version) + "; those from " +
                      std::to_string(int(OPENVDB_FILE_VERSION_ROOTNODE_MAP)) + " to " +
                      std::to_string(int(OPENVDB_FILE_VERSION)) +
                      " can be read here, so it is too old, too new or damaged");
    lengths.skip(2 * sizeof(std::uint32_t));  // the library's version
    lengths.skip(1);                          // whether positions of grids are known
    if (version >= OPENVDB_FILE_VERSION_SELECTIVE_COMPRESSION && version < OPENVDB_FILE_VERSION_NODE_MASK_COMPRESSION)
        lengths.skip(1);  // whether values are compressed
    lengths.skip(version >= OPENVDB_FILE_VERSION_BOOST_UUID ? kTextualId : kBinaryId);
    lengths.metadata();
}

void readGridHead(std::istream& in, std::uintmax_t size, std::uint32_t version, GridHead& head) {
    Lengths lengths(in, size);
    head.name = openvdb::io::GridDescriptor::stripSuffix(lengths.text());
    head.type = lengths.text();
    const bool isInstance =
        version >= openvdb::OPENVDB_FILE_VERSION_GRID_INSTANCING && !lengths.text().empty();  // has another's tree
    lengths.skip(2 * sizeof(openvdb::Int64));  // where grid and values begin
    head.end = lengths.number<openvdb::Int64>();
    if (version >= openvdb::OPENVDB_FILE_VERSION_NODE_MASK_COMPRESSION) lengths.skip(sizeof(std::uint32_t));
    lengths.metadata();
    if (version < openvdb::OPENVDB_FILE_VERSION_GRID_INSTANCING) return;  // the transform is behind the tree
    lengths.transform(version);
    // OpenVDB ends the process where a leaf of points is made with another value.
    if (!isInstance && head.type.rfind("Tree_ptdata", 0) == 0) lengths.requireZeroBackground();
}

}  // namespace raysweep
