// Data flows one way: a module includes only itself and those above it in the list, and links with nothing else.
#include "support/source_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace fs = std::filesystem;

namespace {

const std::vector<std::string> kModules = {"core",    "image",     "camera", "volume",     "mesh",
                                           "formats", "phantoms",  "bricks", "scene",      "render",
                                           "sweep",   "projector", "scan",   "illuminate", "reconstruct"};

std::size_t rankOf(const std::string& module) {
    return std::size_t(std::find(kModules.begin(), kModules.end(), module) - kModules.begin());
}

/// Module named in a line `#include "raysweep/module/..."`; empty for other lines.
std::string includedModule(const std::string& line) {
    const std::string start = "#include \"raysweep/";
    if (line.rfind(start, 0) != 0) return "";
    return line.substr(start.size(), line.find('/', start.size()) - start.size());
}

/// A file of objects, as nm sees it.
struct ObjectFile {
    fs::path path;
    std::size_t rank;
    std::vector<std::string> defined, undefined;
};

/// Standard output of a command.
std::string outputOf(const std::string& command) {
    std::FILE* pipe = popen(command.c_str(), "r");
    if (pipe == nullptr) return "";
    std::string output;
    char buffer[65536];
    for (std::size_t n; (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;) output.append(buffer, n);
    return pclose(pipe) == 0 ? output : "";
}

/// The library's object files, from the list that the build leaves.
std::vector<ObjectFile> libraryObjects() {
    const std::string list = raysweep::test::buildFolder() + "/tests/library_objects.txt";
    // Lines "path: symbol type value size".
    std::istringstream lines(
        outputOf("grep '\\.o$' '" + list + "' | xargs -d '\\n' nm -A --extern-only --format=posix"));
    std::vector<ObjectFile> objects;
    std::string path, symbol, type;
    while (lines >> path >> symbol >> type) {
        lines.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
        path.pop_back();
        if (objects.empty() || objects.back().path != path)
            objects.push_back({path, rankOf(fs::path(path).parent_path().filename().string()), {}, {}});
        const bool isDefined = type != "U" && type != "w" && type != "v";
        (isDefined ? objects.back().defined : objects.back().undefined).push_back(symbol);
    }
    return objects;
}

/// For the mangled names of members of OpenVDB's Tree and Grid of floats or colours.
bool isTreeMember(const std::string& symbol) {
    if (symbol.rfind("_ZN7openvdb", 0) != 0 && symbol.rfind("_ZNK7openvdb", 0) != 0) return false;
    const std::size_t type = symbol.find_first_not_of("0123456789v_", 12);  // after the version's namespace
    if (type == std::string::npos) return false;
    if (symbol.compare(type, 10, "tree4TreeI") != 0 && symbol.compare(type, 5, "GridI") != 0) return false;
    const std::size_t leaf = symbol.find("LeafNodeI", type);
    if (leaf == std::string::npos) return false;
    return symbol[leaf + 9] == 'f' || symbol.find("4Vec3IfE", leaf) + 7 == symbol.find('E', leaf);
}

/// For lines that have an option or a subcommand in a string.
bool namesOption(const std::string& line) {
    const std::size_t quote = line.find('"');
    for (const std::string start : {"--", "raysweep "})
        for (std::size_t at = line.find(start, quote); at != std::string::npos; at = line.find(start, at + 1))
            if (std::islower(static_cast<unsigned char>(line[at + start.size()]))) return true;
    return false;
}

}  // namespace

TEST(Layering, ModulesLinkWithThoseAboveThemAlone) {
    const std::vector<ObjectFile> objects = libraryObjects();
    std::map<std::string, std::size_t> first;  // rank of the first module that defines a symbol
    std::map<std::string, std::string> where;
    std::size_t symbols = 0;
    for (const ObjectFile& object : objects) {
        ASSERT_LT(object.rank, kModules.size()) << object.path << ": a module that is not in the list";
        for (const std::string& symbol : object.defined) {
            const auto known = first.find(symbol);
            if (known != first.end() && known->second <= object.rank) continue;
            first[symbol] = object.rank;
            where[symbol] = object.path.filename().string();
        }
        symbols += object.undefined.size();
    }
    EXPECT_GT(objects.size(), 50u);
    EXPECT_GT(symbols, 1000u);
    for (const ObjectFile& object : objects)
        for (const std::string& symbol : object.undefined) {
            const auto definition = first.find(symbol);
            if (definition == first.end()) continue;  // of a library
            EXPECT_LE(definition->second, object.rank)
                << kModules[object.rank] << "/" << object.path.filename().string() << " needs "
                << outputOf("c++filt '" + symbol + "'") << "from " << kModules[definition->second] << "/"
                << where[symbol];
        }
}

// What makes units slow to compile is OpenVDB's trees: those of float and vec3s are made once.
TEST(Layering, OneUnitInstantiatesTheTrees) {
#ifndef __OPTIMIZE__
    GTEST_SKIP() << "without optimisation every unit holds the inline members that it calls";
#endif
    std::set<std::string> units;
    for (const ObjectFile& object : libraryObjects())
        for (const std::string& symbol : object.defined)
            if (isTreeMember(symbol) &&
                symbol.find("4once") == std::string::npos)  // a flag that inline functions leave
                units.insert(object.path.filename().string());
    EXPECT_EQ(units, std::set<std::string>{"grids.cpp.o"});
}

TEST(Layering, ModulesIncludeOnlyThoseAboveThem) {
    const fs::path library = fs::path(raysweep::test::sourceFolder()) / "lib" / "raysweep";
    int files = 0;
    for (const auto& entry : fs::recursive_directory_iterator(library)) {
        if (!entry.is_regular_file() || entry.path().parent_path() == library) continue;
        const std::string module = fs::relative(entry.path(), library).begin()->string();
        ASSERT_LT(rankOf(module), kModules.size()) << entry.path() << ": a module that is not in the list";
        std::ifstream source(entry.path());
        for (std::string line; std::getline(source, line);) {
            const std::string included = includedModule(line);
            if (included.empty()) continue;
            EXPECT_LE(rankOf(included), rankOf(module)) << entry.path() << ": " << line;
        }
        ++files;
    }
    EXPECT_GT(files, 20);
}

TEST(Layering, NoMessageNamesAnOption) {
    const fs::path library = fs::path(raysweep::test::sourceFolder()) / "lib" / "raysweep";
    for (const auto& entry : fs::recursive_directory_iterator(library)) {
        if (!entry.is_regular_file()) continue;
        std::ifstream source(entry.path());
        for (std::string line; std::getline(source, line);)
            EXPECT_FALSE(namesOption(line)) << entry.path() << ": " << line;
    }
}

TEST(Layering, FewFilesSeeThreadsPicturesAndFormatsOfOthers) {
    const std::vector<std::string> medical = {"dicom_frames.cpp", "dicom_header.cpp", "dicom_pixels.cpp",
                                              "itk_silence.cpp", "itk_write.cpp"};
    const std::vector<std::string> readers = {"picture_layout.cpp", "rtk_geometry.cpp"};
    const fs::path library = fs::path(raysweep::test::sourceFolder()) / "lib" / "raysweep";
    for (const auto& entry : fs::recursive_directory_iterator(library)) {
        if (!entry.is_regular_file()) continue;
        std::ifstream source(entry.path());
        for (std::string line; std::getline(source, line);) {
            if (line.rfind("#include", 0) != 0) continue;
            const bool threads = line.find("tbb/") != std::string::npos;
            const bool pictures = line.find("OpenImageIO") != std::string::npos;
            const bool tiff = line.find("tiffio") != std::string::npos;
            const bool exr = line.find("OpenEXR/") != std::string::npos;
            const bool itk = line.find("<itk") != std::string::npos || line.find("<gdcm") != std::string::npos ||
                             line.find("<dcmtk") != std::string::npos;
            EXPECT_TRUE(!itk || std::count(medical.begin(), medical.end(), entry.path().filename().string()) == 1)
                << entry.path() << ": " << line;
            const bool fourier = line.find("kissfft") != std::string::npos;
            EXPECT_TRUE(!fourier || entry.path().filename() == "ramp_filter.cpp") << entry.path() << ": " << line;
            const bool blosc = line.find("<blosc") != std::string::npos;
            EXPECT_TRUE(!blosc || entry.path().filename() == "vdb_unpack.cpp") << entry.path() << ": " << line;
            const bool hdf5 = line.find("<hdf5") != std::string::npos || line.find("<H5") != std::string::npos;
            const bool xml = line.find("pugixml") != std::string::npos;
            EXPECT_TRUE(!hdf5 || entry.path().filename().string().rfind("hdf5_", 0) == 0)
                << entry.path() << ": " << line;
            EXPECT_TRUE(!xml || std::count(readers.begin(), readers.end(), entry.path().filename().string()) == 1)
                << entry.path() << ": " << line;
            EXPECT_TRUE(!threads || entry.path().filename() == "parallel.h") << entry.path() << ": " << line;
            EXPECT_TRUE(!pictures || entry.path().filename() == "picture_module.cpp") << entry.path() << ": " << line;
            EXPECT_TRUE(!tiff || entry.path().filename() == "tiff_file.cpp") << entry.path() << ": " << line;
            EXPECT_TRUE(!exr || entry.path().filename() == "exr.cpp") << entry.path() << ": " << line;
        }
    }
}
