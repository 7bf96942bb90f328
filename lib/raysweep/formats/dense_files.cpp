#include "raysweep/formats/dense_files.h"

#include "raysweep/core/brief.h"
#include "raysweep/core/file_name.h"
#include "raysweep/core/output_file.h"
#include "raysweep/core/output_folder.h"
#include "raysweep/formats/dense_headers.h"
#include "raysweep/formats/header_lines.h"

#include <zlib.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

namespace fs = std::filesystem;

namespace raysweep {
namespace {

constexpr double kMostDeflated = 1032;  ///< bytes that deflate packs into one

[[noreturn]] void fail(const std::string& path, const std::string& why) {
    throw IoError("cannot write '" + path + "': " + why);
}

bool isPacked(const std::string& path) {
    return lowerExtension(path) == ".gz";
}

bool isSlice(const std::string& name) {
    const std::string begin = "slice_", end = ".tif";
    const std::size_t digits = name.find_first_not_of("0123456789", begin.size());
    return name.rfind(begin, 0) == 0 && digits != std::string::npos && digits > begin.size() &&
           name.substr(digits) == end;
}

std::string sliceName(int k) {
    char name[32];
    std::snprintf(name, sizeof name, "slice_%04d.tif", k);
    return name;
}

/// Where the output will be, and all of it has to fit beside what is there.
fs::path folderAround(const std::string& path) {
    const fs::path all = fs::absolute(path).lexically_normal();
    return all.has_filename() ? all.parent_path() : all.parent_path().parent_path();
}

void requireRoom(const std::string& path, const DenseLayout& layout) {
    const double bytes = double(layout.samples()) * sizeof(float),
                 least = isPacked(path) ? bytes / kMostDeflated : bytes;
    std::error_code failed;
    const fs::space_info room = fs::space(folderAround(path), failed);
    if (failed || least <= double(room.available)) return;
    const std::string size = std::to_string(layout.dims.x) + "x" + std::to_string(layout.dims.y) + "x" +
                             std::to_string(layout.dims.z) + " voxels, " + brief(bytes / 1e9, 3) + " GB";
    fail(path, "it would have " + size + ", and " + brief(double(room.available) / 1e9, 3) +
                   " GB are free there; choose a smaller part by `denseBox`, or use a coarser grid");
}

/// A file that is written from its beginning to its end, compressed or not.
class Writer {
  public:
    Writer(const std::string& target, const std::string& path, bool packed) : target_(target) {
        constexpr const char* kPlain = "wbT";
        constexpr const char* kQuick = "wb3";  // floats that were measured hardly get smaller by more
        file_.reset(gzopen(path.c_str(), packed ? kQuick : kPlain));
        if (!file_) fail(target_, "it cannot be opened");
        gzbuffer(file_.get(), 1u << 20);
    }

    void write(const void* bytes, std::size_t count) {
        constexpr std::size_t kPiece = std::size_t(1) << 30;
        for (const char* at = static_cast<const char*>(bytes); count > 0;) {
            const std::size_t piece = std::min(count, kPiece);
            if (gzwrite(file_.get(), at, unsigned(piece)) != int(piece)) failFull();
            at += piece, count -= piece;
        }
    }

    void close() {
        if (gzclose(file_.release()) != Z_OK) failFull();
    }

  private:
    struct Close {
        void operator()(gzFile file) const { gzclose(file); }
    };

    [[noreturn]] void failFull() const { fail(target_, "writing failed; is the disk full?"); }

    std::string target_;
    std::unique_ptr<gzFile_s, Close> file_;
};

void writeFile(const std::string& path, const std::string& header, DenseSource& source) {
    const Index3& dims = source.layout().dims;
    OutputFile file(path);
    Writer writer(path, file.temporary(), isPacked(path));
    writer.write(header.data(), header.size());
    for (int k = 0; k < dims.z; ++k)
        writer.write(source.slice(k), std::size_t(dims.x) * std::size_t(dims.y) * sizeof(float));
    writer.close();
    file.commit();
}

void writeSlices(const std::string& path, DenseSource& source) {
    const Index3& dims = source.layout().dims;
    OutputFolder folder(path, isSlice);
    for (int k = 0; k < dims.z; ++k) {
        const std::string header = tiffHeader(source.layout(), k);
        Writer writer(path, (fs::path(folder.temporary()) / sliceName(k)).string(), false);
        writer.write(header.data(), header.size());
        writer.write(source.slice(k), std::size_t(dims.x) * std::size_t(dims.y) * sizeof(float));
        writer.close();
    }
    folder.commit();
}

}  // namespace

DenseFormat denseFormat(const std::string& path) {
    const std::string name = lowerCase(fs::path(path).filename().string()), extension = lowerExtension(path);
    if (name.empty()) return DenseFormat::tiffFolder;
    if (extension == ".mha") return DenseFormat::metaImage;
    if (extension == ".nrrd") return DenseFormat::nrrd;
    if (extension == ".nii") return DenseFormat::nifti;
    if (extension == ".gz" && lowerExtension(fs::path(name).stem().string()) == ".nii") return DenseFormat::nifti;
    std::error_code ignored;
    const bool folder = extension.empty() || (extension != ".vdb" && fs::is_directory(path, ignored));
    return folder ? DenseFormat::tiffFolder : DenseFormat::unknown;
}

void requireDenseOutput(const std::string& path) {
    if (denseFormat(path) != DenseFormat::tiffFolder) return requireWritable(path);
    const OutputFolder couldBe(path, isSlice);
}

void writeDense(const std::string& path, DenseSource& source) {
    const DenseLayout& layout = source.layout();
    const DenseFormat format = denseFormat(path);
    requireRoom(path, layout);
    switch (format) {
        case DenseFormat::metaImage:
            return writeFile(path, metaImageHeader(layout), source);
        case DenseFormat::nrrd:
            return writeFile(path, nrrdHeader(layout), source);
        case DenseFormat::nifti:
            return writeFile(path, niftiHeader(layout), source);
        case DenseFormat::tiffFolder:
            return writeSlices(path, source);
        case DenseFormat::unknown:
            break;
    }
    fail(path, std::string("its ending is not known; give ") + kDenseEndings);
}

}  // namespace raysweep
