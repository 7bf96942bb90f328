#include "raysweep/volume/vdb_io.h"

#include "raysweep/core/error.h"
#include "raysweep/core/output_file.h"

#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace raysweep {
namespace {

using openvdb::GridBase;
using openvdb::io::GridDescriptor;

/// io::File neither notices a file that ends too early nor a disk that is full, because the streams it opens report
/// no failure. Its base class does the work and takes any stream, so here it gets streams that throw.
class Archive : public openvdb::io::Archive {
  public:
    void read(std::istream& in, VdbFile& file);
    void save(std::ostream& out, const openvdb::GridCPtrVec& grids, const openvdb::MetaMap& metadata) const {
        openvdb::io::Archive::write(out, grids, /*seekable=*/true, metadata);
    }

  private:
    GridBase::Ptr readNext(std::istream& in, GridDescriptor& descriptor, int number, int count) const;
};

void Archive::read(std::istream& in, VdbFile& file) {
    openvdb::io::StreamMetadata::Ptr streamMetadata(new openvdb::io::StreamMetadata);
    streamMetadata->setSeekable(true);
    openvdb::io::setStreamMetadataPtr(in, streamMetadata, /*transfer=*/false);
    readHeader(in);
    setFormatVersion(in);
    setLibraryVersion(in);
    setDataCompression(in);
    file.metadata.readMeta(in);

    NamedGridMap named;
    std::vector<GridDescriptor> descriptors(static_cast<std::size_t>(std::max(0, readGridCount(in))));
    for (std::size_t i = 0; i < descriptors.size(); ++i) {
        file.grids.push_back(readNext(in, descriptors[i], int(i) + 1, int(descriptors.size())));
        named[descriptors[i].uniqueName()] = file.grids.back();
    }
    for (const GridDescriptor& descriptor : descriptors)
        if (descriptor.isInstance()) connectInstance(descriptor, named);
}

GridBase::Ptr Archive::readNext(std::istream& in, GridDescriptor& descriptor, int number, int count) const {
    GridBase::Ptr grid;
    try {
        grid = descriptor.read(in);
        readGrid(grid, descriptor, in);
        return grid;
    } catch (const std::exception& e) {
        // A tree that was read half must not be destroyed: the slots of children that were not reached yet hold
        // values that OpenVDB's destructor would take for pointers. Forgetting it is the lesser evil.
        if (grid) new GridBase::Ptr(grid);
        if (dynamic_cast<const std::bad_alloc*>(&e)) throw;
        const std::string which = "grid " + std::to_string(number) + " of " + std::to_string(count) +
                                  (descriptor.gridName().empty() ? "" : " ('" + descriptor.gridName() + "')");
        throw IoError(which + ": " + (in.eof() ? "the file ends inside it" : e.what()));
    }
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

}  // namespace

VdbFile readVdb(const std::string& path) {
    initializeGrids();
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored)) failRead(path, "it is a folder; give a .vdb file");
    errno = 0;
    std::ifstream in(path, std::ios::binary);
    if (!in) failRead(path, systemError());
    requireVdb(in, path);
    in.exceptions(std::ios::failbit | std::ios::badbit);
    VdbFile file;
    file.path = path;
    try {
        Archive().read(in, file);
    } catch (const IoError& e) {
        failRead(path, std::string(e.what()) +
                           "; the file is truncated or damaged, or holds a type of grid this "
                           "build does not know; write it again");
    } catch (const std::ios_base::failure&) {
        failRead(path, "the file ends inside its header; it is truncated, write it again");
    } catch (const openvdb::Exception& e) {
        failRead(path, e.what());
    }
    return file;
}

void writeVdb(const std::string& path, const openvdb::GridCPtrVec& grids, const openvdb::MetaMap& metadata) {
    initializeGrids();
    OutputFile target(path);
    errno = 0;
    std::ofstream out(target.temporary(), std::ios::binary | std::ios::trunc);
    if (!out) failWrite(path, systemError());
    out.exceptions(std::ios::failbit | std::ios::badbit);
    try {
        Archive().save(out, grids, metadata);
        out.close();
    } catch (const std::ios_base::failure&) {
        failWrite(path, systemError() + "; the file was not written, and one that was there is unchanged");
    } catch (const openvdb::Exception& e) {
        failWrite(path, e.what());
    }
    target.commit();
}

}  // namespace raysweep
