#include "raysweep/formats/picture_volume.h"

#include "raysweep/core/claimed_room.h"
#include "raysweep/core/error.h"
#include "raysweep/core/memory.h"
#include "raysweep/formats/header_lines.h"
#include "raysweep/formats/picture_layout.h"
#include "raysweep/formats/read_failure.h"
#include "raysweep/image/exr.h"
#include "raysweep/image/picture_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace raysweep {
namespace {

/// A picture of the volume: a page of a file, and a channel of that.
struct Slice {
    std::size_t file = 0;
    int page = 0, channel = 0;
};

std::string numbered(const std::string& file, int page) {
    return "'" + file + "'" + (page > 0 ? ", page " + std::to_string(page + 1) : "");
}

/// What all slices have to be.
struct Plan {
    std::vector<Slice> slices;
    PicturePage first;
    PictureLayout layout;
};

void requireSlice(const PicturePage& page, const PicturePage& first, const std::string& path, int number) {
    const auto fail = [&](const std::string& why) {
        throw InvalidArgument("cannot use " + numbered(path, number) + ": " + why);
    };
    if (page.depth > 1) fail("it has a depth of its own; a stack is made of flat pictures");
    const auto size = [](const PicturePage& p) { return std::to_string(p.width) + "x" + std::to_string(p.height); };
    if (page.width != first.width || page.height != first.height)
        fail("its size is " + size(page) + ", but the first picture's is " + size(first) +
             "; all slices must have one size");
    if (!page.type) fail("samples that are " + page.typeName + " are not known; convert it first");
    if (page.type != first.type || page.highest != first.highest)
        fail("its samples are " + nameOf(*page.type) + (page.highest > 0 ? " of fewer bits" : "") +
             ", but the first picture's are " + nameOf(first.type.value_or(*page.type)) +
             "; all slices must have one type");
    if (page.channels != first.channels)
        fail("it has " + std::to_string(page.channels) + " channels, but the first picture has " +
             std::to_string(first.channels));
    if (page.left != first.left || page.top != first.top)
        fail("its pixels begin at (" + std::to_string(page.left) + ", " + std::to_string(page.top) +
             "), but the first picture's at (" + std::to_string(first.left) + ", " + std::to_string(first.top) + ")");
}

std::function<std::string(int)> namesOf(std::vector<std::string> names, std::uint64_t count) {
    const bool any = std::any_of(names.begin(), names.end(), [](const std::string& name) { return !name.empty(); });
    if (!any || names.size() < count) return {};
    return [names = std::move(names)](int n) { return names[std::size_t(n)]; };
}

/// Pages of `pages` that are slices of the volume that is meant, as the layout says.
std::vector<int> pagesOfLayout(const std::string& path, const PictureLayout& layout, const std::vector<int>& pages,
                               const VolumeChoice& choice) {
    const auto channels = std::uint64_t(layout.channels), frames = std::uint64_t(layout.frames);
    if (channels * frames * std::uint64_t(layout.slices) != pages.size())
        throw InvalidArgument("'" + path + "' has " + std::to_string(pages.size()) + " pages, but " + layout.program +
                              " promises " + std::to_string(layout.channels) + " channels x " +
                              std::to_string(layout.slices) + " slices x " + std::to_string(layout.frames) +
                              " frames; save it again as one plain stack");
    const int frame = chooseVolume(path, {frames, "volumes (frames)", {}}, choice);
    const int channel =
        channels > 1 ? chooseChannel(path, {channels, "channels", namesOf(layout.channelNames, channels)}, choice) : 0;
    std::vector<int> chosen;
    for (int slice = 0; slice < layout.slices; ++slice)
        chosen.push_back(pages[std::size_t(layout.page(channel, slice, frame))]);
    return chosen;
}

/// Parts of an EXR are pictures of different things, not slices.
std::vector<int> partOf(const std::string& path, PictureFile& file, const std::vector<int>& pages,
                        const VolumeChoice& choice) {
    std::vector<std::string> names;
    for (const int page : pages) names.push_back(file.page(page).name);
    return {pages[std::size_t(chooseVolume(path, {pages.size(), "parts", namesOf(names, pages.size())}, choice))]};
}

/// Adds the slices of one file.
void addFile(const std::vector<std::string>& files, std::size_t n, const VolumeChoice& choice, Plan& plan) {
    const std::string& path = files[n];
    const auto file = openStoredPicture(path);
    std::vector<int> pages;
    for (int page = 0, end = file->pages(); page < end; ++page)  // asking how many may read through all
        if (!file->page(page).extra) pages.push_back(page);
    if (pages.empty()) failRead(path, "it has no picture but smaller copies and masks");
    const PicturePage first = file->page(pages.front());
    const PictureLayout layout = pictureLayout(path, file->description(), first.columnsPerUnit, first.rowsPerUnit);
    if (layout.known)
        pages = pagesOfLayout(path, layout, pages, choice);
    else if (isExr(path))
        pages = partOf(path, *file, pages, choice);
    else
        chooseVolume(path, {}, choice);
    const PicturePage& shown = file->page(pages.front());
    if (n == 0) plan.first = shown, plan.layout = layout;
    if (layout.rescaling.slope != plan.layout.rescaling.slope ||
        layout.rescaling.intercept != plan.layout.rescaling.intercept)
        throw InvalidArgument("'" + path + "' is calibrated in another way than '" + files.front() + "'");
    requireSlice(shown, plan.first, path, pages.front());
    const bool paged = layout.channels > 1;  // then the channel that is chosen is a page
    if (paged && shown.channels > 1)
        throw InvalidArgument("'" + path + "' has channels in its pages and in its pixels; save one of them first");
    const auto side = std::uint64_t(shown.channels);
    const int channel = paged ? 0 : chooseChannel(path, {side, "channels", namesOf(shown.channelNames, side)}, choice);
    for (const int page : pages) plan.slices.push_back({n, page, channel});
}

double bytesIn(const std::vector<std::string>& files) {
    double size = 0;
    for (const std::string& file : files) size += double(sizeOfFile(file));
    return size;
}

/// Where pixels are, if anything says so.
void placeVolume(const Plan& plan, StoredVolume& volume) {
    if (plan.layout.place) {
        volume.origin = plan.layout.place->origin;
        volume.steps = plan.layout.place->steps;
        return;
    }
    const Vec3& spacing = plan.layout.spacing;
    for (int axis = 0; axis < 3; ++axis)
        if (spacing[axis] > 0) volume.steps[std::size_t(axis)] *= spacing[axis];
    volume.unit = plan.layout.unit;
    volume.origin = volume.steps[0] * double(plan.first.left) + volume.steps[1] * double(plan.first.top);
}

}  // namespace

StoredVolume readPictures(const std::vector<std::string>& files, const VolumeChoice& choice,
                          const ProgressCallback& progress) {
    Plan plan;
    for (std::size_t n = 0; n < files.size(); ++n) addFile(files, n, choice, plan);

    StoredVolume volume;
    volume.format = "pictures";
    volume.type = plan.first.type.value();
    volume.highest = plan.first.highest;
    volume.dims = Index3(plan.first.width, plan.first.height, int(plan.slices.size()));
    placeVolume(plan, volume);
    const std::size_t sliceBytes = std::size_t(plan.first.width) * std::size_t(plan.first.height) * sizeOf(volume.type);
    requireRoom(files.front(), double(sliceBytes) * double(plan.slices.size()), bytesIn(files));
    requireBytes(double(sliceBytes) * double(plan.slices.size()), "'" + files.front() + "': the pictures need",
                 "take fewer or smaller ones");
    volume.samples.reset(new std::byte[sliceBytes * plan.slices.size()]);
    std::unique_ptr<PictureFile> file;
    for (std::size_t n = 0; n < plan.slices.size(); ++n) {
        volume.complete = report(progress, "reading", double(n) / double(plan.slices.size()));
        if (!volume.complete) return volume;
        const Slice& slice = plan.slices[n];
        const std::string& path = files[slice.file];
        if (!file || slice.file != plan.slices[n - 1].file) file = openStoredPicture(path);
        requireSlice(file->page(slice.page), plan.first, path, slice.page);
        file->readSamples(slice.page, slice.channel, volume.samples.get() + n * sliceBytes);
    }
    rescale(volume, plan.layout.rescaling);
    return volume;
}

}  // namespace raysweep
