#include "raysweep/volume/vdb_io.h"

#include "raysweep/core/error.h"
#include "raysweep/core/output_file.h"
#include "raysweep/core/regular_file.h"
#include "raysweep/core/run_outputs.h"
#include "raysweep/volume/input_file.h"
#include "raysweep/volume/leaf_writer.h"
#include "raysweep/volume/vdb_lengths.h"

#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <vector>

namespace raysweep {
namespace {

using openvdb::GridBase;
using openvdb::io::GridDescriptor;

const char* const kEndsInside = "the file ends inside it; it is truncated or damaged, write it again";

/// What is wrong with one grid, as against no memory.
bool isOfGrid(const std::exception& e) {
    return dynamic_cast<const IoError*>(&e) || dynamic_cast<const std::ios_base::failure*>(&e);
}

/// io::File neither notices a file that ends too early nor a disk that is full, because the streams it opens report
/// no failure. Its base class does the work and takes any stream, so here it gets streams that throw.
class Archive : public openvdb::io::Archive {
  public:
    /// @param unreadable takes grids that cannot be read, which are passed over; null: they are errors
    void read(std::istream& in, std::uintmax_t size, VdbFile& file, std::vector<UnreadableGrid>* unreadable);
    void save(std::ostream& out, const openvdb::GridCPtrVec& grids, const openvdb::MetaMap& metadata) const;

  private:
    GridBase::Ptr readNext(std::istream& in, GridDescriptor& descriptor) const;
    /// Adds to the metadata of `grid`.
    void writeNext(std::ostream& out, GridDescriptor& descriptor, GridBase& grid) const;
};

/// OpenVDB's own arithmetic on coordinates overflows at the ends of their range.
void requireNear(const GridBase& grid) {
    openvdb::CoordBBox active, leaves;
    grid.baseTree().evalActiveVoxelBoundingBox(active);
    grid.baseTree().evalLeafBoundingBox(leaves);
    const auto require = [](const openvdb::CoordBBox& box, int farthest) {
        for (int axis = 0; axis < 3 && !box.empty(); ++axis)
            for (const openvdb::Coord& corner : {box.min(), box.max()})
                if (corner[axis] < -farthest || corner[axis] > farthest)
                    throw IoError("it has voxels at " + std::to_string(corner[axis]) + " along " + "xyz"[axis] +
                                  ", farther from 0 than " + std::to_string(kFarthestVoxel) +
                                  "; move them near 0 and place the grid by its transform");
    };
    constexpr int kLeaf = 8;  // what is in a leaf need not be active up to its end
    require(active, kFarthestVoxel);
    require(leaves, kFarthestVoxel + kLeaf);
}

void Archive::read(std::istream& in, std::uintmax_t size, VdbFile& file, std::vector<UnreadableGrid>* unreadable) {
    openvdb::io::StreamMetadata::Ptr streamMetadata(new openvdb::io::StreamMetadata);
    streamMetadata->setSeekable(true);
    openvdb::io::setStreamMetadataPtr(in, streamMetadata, /*transfer=*/false);
    requireHeaderLengths(in, size);
    readHeader(in);
    setFormatVersion(in);
    setLibraryVersion(in);
    setDataCompression(in);
    file.metadata.readMeta(in);

    NamedGridMap named;
    std::vector<GridDescriptor> descriptors;  // grows as it is read: the count of a damaged file may be anything
    const int count = readGridCount(in);
    for (int i = 0; i < count; ++i) {
        GridHead head;
        GridDescriptor descriptor;
        const std::streamoff start = in.tellg();
        try {
            readGridHead(in, size, openvdb::io::getFormatVersion(in), head);
            const GridBase::Ptr grid = readNext(in, descriptor);
            named[descriptor.uniqueName()] = grid;
            descriptors.push_back(descriptor);
            file.grids.push_back(grid);
        } catch (const std::exception& e) {
            if (!isOfGrid(e)) throw;
            const std::string why = dynamic_cast<const std::ios_base::failure*>(&e) ? kEndsInside : e.what();
            const std::string which = "grid " + std::to_string(i + 1) + " of " + std::to_string(count) +
                                      (head.name.empty() ? "" : " ('" + head.name + "')");
            if (!unreadable) throw IoError(which + ": " + why);
            const bool lost = head.end <= start || std::uintmax_t(head.end) > size;
            unreadable->push_back({head.name, head.type, which + ": " + why});
            in.clear();
            if (lost && i + 1 < count) unreadable->back().error += "; where those after it begin is not known";
            if (lost) break;
            in.seekg(head.end);
        }
    }
    for (const GridDescriptor& descriptor : descriptors)
        if (descriptor.isInstance()) connectInstance(descriptor, named);
}

/// Names that no other grid has: those that several have are told apart by numbers that OpenVDB hides from users.
std::vector<std::string> uniqueNames(const openvdb::GridCPtrVec& grids) {
    std::map<std::string, int> count;
    for (const auto& grid : grids) ++count[grid->getName()];
    std::set<std::string> taken;
    std::vector<std::string> names;
    for (const auto& grid : grids) {
        const std::string own = grid->getName();
        std::string name = count[own] > 1 ? GridDescriptor::addSuffix(own, 0) : own;
        for (int n = 1; taken.count(name) > 0; ++n) name = GridDescriptor::addSuffix(own, n);
        taken.insert(name);
        names.push_back(name);
    }
    return names;
}

/// As its base class does it, but for one thing: that writes with each grid how long each of its leaves is compressed,
/// and to know it compresses all of them one more time. It is of use only to who reads some leaves later than others;
/// newer versions of OpenVDB do not write it.
void Archive::save(std::ostream& out, const openvdb::GridCPtrVec& grids, const openvdb::MetaMap& metadata) const {
    writeHeader(out, /*seekable=*/true);
    metadata.writeMeta(out);
    const auto count = std::int32_t(grids.size());
    out.write(reinterpret_cast<const char*>(&count), sizeof count);
    const std::vector<std::string> names = uniqueNames(grids);
    std::map<const openvdb::TreeBase*, GridDescriptor> written;
    for (std::size_t i = 0; i < grids.size(); ++i) {
        const GridBase& grid = *grids[i];
        GridDescriptor descriptor(names[i], grid.type(), grid.saveFloatAsHalf());
        const auto same = written.find(&grid.constBaseTree());
        if (same != written.end() && same->second.saveFloatAsHalf() == grid.saveFloatAsHalf()) {
            descriptor.setInstanceParentName(same->second.uniqueName());
            writeGridInstance(descriptor, grids[i], out, /*seekable=*/true);
        } else {
            writeNext(out, descriptor, *writtenInParallel(grids[i]));
            written[&grid.constBaseTree()] = descriptor;
        }
    }
}

void Archive::writeNext(std::ostream& out, GridDescriptor& descriptor, GridBase& grid) const {
    grid.removeMeta(GridBase::META_FILE_DELAYED_LOAD);
    grid.addStatsMetadata();
    const std::string compression = openvdb::io::compressionToString(this->compression());
    grid.insertMeta(GridBase::META_FILE_COMPRESSION, openvdb::StringMetadata(compression));

    auto streamMetadata = std::make_shared<openvdb::io::StreamMetadata>();
    openvdb::io::setStreamMetadataPtr(out, streamMetadata, /*transfer=*/false);
    streamMetadata->setHalfFloat(grid.saveFloatAsHalf());
    streamMetadata->gridMetadata() = grid;
    descriptor.writeHeader(out);
    const std::streamoff positions = out.tellp();
    descriptor.writeStreamPos(out);  // not known yet
    descriptor.setGridPos(out.tellp());
    setGridCompression(out, grid);
    grid.writeMeta(out);
    grid.writeTransform(out);
    grid.writeTopology(out);
    descriptor.setBlockPos(out.tellp());
    grid.writeBuffers(out);
    descriptor.setEndPos(out.tellp());
    out.seekp(positions);
    descriptor.writeStreamPos(out);
    descriptor.seekToEnd(out);
    openvdb::io::clearStreamMetadataPtr(out);
}

GridBase::Ptr Archive::readNext(std::istream& in, GridDescriptor& descriptor) const {
    GridBase::Ptr grid;
    try {
        grid = descriptor.read(in);
        readGrid(grid, descriptor, in);
    } catch (const std::exception& e) {
        // A tree that was read half must not be destroyed: the slots of children that were not reached yet hold
        // values that OpenVDB's destructor would take for pointers. Keeping it for good is the lesser evil.
        if (grid) static_cast<void>(new GridBase::Ptr(grid));
        if (dynamic_cast<const std::bad_alloc*>(&e)) throw;
        throw IoError(in.eof() ? kEndsInside
                               : std::string(e.what()) + "; the file is damaged, or too new for this build");
    }
    requireNear(*grid);
    return grid;
}

[[noreturn]] void failRead(const std::string& path, const std::string& why) {
    throw IoError("cannot read '" + path + "': " + why);
}

[[noreturn]] void failWrite(const std::string& path, const std::string& why) {
    throw IoError("cannot write '" + path + "': " + why);
}

std::string systemError() {
    return errno ? std::strerror(errno) : "the stream failed";
}

void requireVdb(std::istream& in, const std::string& path) {
    openvdb::Int64 magic = 0;
    in.read(reinterpret_cast<char*>(&magic), sizeof magic);
    if (in.gcount() == 0) failRead(path, "the file is empty");
    if (!in || magic != openvdb::OPENVDB_MAGIC) failRead(path, "this is not an OpenVDB file (.vdb)");
    in.seekg(0);
}

VdbFile read(const std::string& path, std::vector<UnreadableGrid>* unreadable) {
    initializeGrids();
    if (const std::string why = whyNotRegular(path, "a .vdb file"); !why.empty()) failRead(path, why);
    errno = 0;
    std::error_code ignored;
    const std::uintmax_t size = std::filesystem::file_size(path, ignored);
    InputFile buffer(path, size);
    if (!buffer.isOpen()) failRead(path, systemError());
    noteInput(path);
    std::istream in(&buffer);
    requireVdb(in, path);
    in.exceptions(std::ios::failbit | std::ios::badbit);
    VdbFile file;
    file.path = path;
    try {
        Archive().read(in, size, file, unreadable);
    } catch (const IoError& e) {
        failRead(path, e.what());
    } catch (const std::ios_base::failure&) {
        failRead(path, "the file ends inside its header; it is truncated, write it again");
    } catch (const std::bad_alloc&) {
        failRead(path, "there is not enough memory for it, or the file is damaged");
    } catch (const std::exception& e) {
        failRead(path, e.what());
    }
    return file;
}

}  // namespace

VdbFile readVdb(const std::string& path) {
    return read(path, nullptr);
}

VdbSurvey surveyVdb(const std::string& path) {
    VdbSurvey survey;
    survey.file = read(path, &survey.unreadable);
    return survey;
}

void writeVdb(OutputFile& file, const openvdb::GridCPtrVec& grids, const openvdb::MetaMap& metadata) {
    initializeGrids();
    errno = 0;
    std::ofstream out(file.temporary(), std::ios::binary | std::ios::trunc);
    if (!out) failWrite(file.target(), systemError());
    out.exceptions(std::ios::failbit | std::ios::badbit);
    try {
        Archive().save(out, grids, metadata);
        out.close();
    } catch (const std::ios_base::failure&) {
        failWrite(file.target(), systemError() + "; the file was not written, and one that was there is unchanged");
    } catch (const openvdb::Exception& e) {
        failWrite(file.target(), e.what());
    }
}

void writeVdb(const std::string& path, const openvdb::GridCPtrVec& grids, const openvdb::MetaMap& metadata) {
    OutputFile file(path);
    writeVdb(file, grids, metadata);
    file.commit();
}

}  // namespace raysweep
