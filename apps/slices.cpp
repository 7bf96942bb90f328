/// raysweep slices: three sections of a volume, as a picture or as a page to scroll through.
#include "dense_options.h"
#include "hints.h"

#include "raysweep/core/file_name.h"
#include "raysweep/core/output_file.h"
#include "raysweep/formats/sections.h"
#include "raysweep/image/image_io.h"

#include <nlohmann/json.hpp>

#include <memory>

namespace raysweep::apps {
namespace {

struct Arguments {
    CommonOptions common;
    std::string input, output, at, window;
    DenseArguments dense;
    SectionOptions sections;
};

bool isPage(const std::string& path) {
    return lowerExtension(path) == ".html";
}

/// Everything that can be said to be wrong before a file is read.
void completeOptions(Arguments& a, const CLI::App& command) {
    requireFileOutput(a.output);
    if (!isPage(a.output) && imageFormat(a.output) != ImageFormat::Png)
        usageError("--output", "'" + a.output + "' must end in .png or .html");
    denseChoice(a.dense);
    if (!a.at.empty()) a.sections.at = parseVec3(a.at, "--at");
    if (!a.window.empty()) {
        const std::vector<double> ends = parseNumbers(a.window, "--window", 2, 2, "0,1.5");
        a.sections.window = GreyWindow{ends[0], ends[1]};
    }
    requireValid(command, [&] { a.sections.validate(); });
}

nlohmann::ordered_json describe(const std::string& grid, const Sections& sections, double seconds) {
    const auto list = [](const auto& v) { return nlohmann::ordered_json{v.x, v.y, v.z}; };
    Vec3 at = sections.layout.origin;
    for (int axis = 0; axis < 3; ++axis) at += sections.layout.steps[std::size_t(axis)] * double(sections.at[axis]);
    return {{"grid", grid},
            {"dims", list(sections.layout.dims)},
            {"voxel", list(sections.corner + sections.at)},
            {"at", list(at)},
            {"window", {sections.window.low, sections.window.high}},
            {"range", {sections.smallest, sections.largest}},
            {"seconds", seconds}};
}

void run(const Arguments& a) {
    const ThreadLimit limit = start(a.common);
    requireWritable(a.output);
    const Timer timer;
    DenseSource source = denseSource(a.input, a.dense);
    const Sections sections = sectionsOf(source, a.sections);
    if (isPage(a.output))
        writeSectionPage(a.output, source, a.sections, sections);
    else
        writeImage(a.output, sectionPicture(sections));
    writeReport(a.common, describe(source.name(), sections, timer.seconds()));
}

}  // namespace

void addSlices(CLI::App& app, int&) {
    CLI::App* command = app.add_subcommand("slices", "Look into a volume: three sections, as a picture or a page");
    const auto a = std::make_shared<Arguments>();
    reads(command->add_option("input", a->input, "Volume"))->required()->type_name("VOL.vdb");
    writes(command->add_option("-o,--output", a->output,
                               ".png: three sections with scale and window; .html: one page, without anything else, "
                               "to scroll through them, with the value under the pointer (8 bits)"))
        ->required()
        ->type_name("OUT.png|.html");
    command->add_option("--at", a->at, "Where the sections meet, world units (default: the middle)")
        ->type_name("X,Y,Z");
    command
        ->add_option("--window", a->window, "Values that are black and white (default: the smallest and the largest)")
        ->type_name("LO,HI");
    addDenseOptions(*command, a->dense);
    addCommonOptions(*command, a->common);
    command->callback([a, command] {
        completeOptions(*a, *command);
        run(*a);
    });
}

}  // namespace raysweep::apps
