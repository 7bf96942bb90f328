#include "raysweep/core/run_outputs.h"

#include "raysweep/core/error.h"
#include "raysweep/core/temporaries.h"

#include <sys/stat.h>

#include <filesystem>
#include <mutex>
#include <set>
#include <utility>
#include <vector>

namespace fs = std::filesystem;

namespace raysweep {
namespace {

struct Waiting {
    std::function<void()> move;
    std::string temporary;
};

using Inode = std::pair<dev_t, ino_t>;

struct Run {
    std::vector<Waiting> waiting;
    std::vector<fs::path> folders;  ///< that were made, outer ones first
    std::set<Inode> inputs, outputs;
};

std::mutex runLock;
std::unique_ptr<Run> run;

bool inodeOf(const std::string& path, Inode& inode) {
    struct stat found;
    if (::stat(path.c_str(), &found) != 0) return false;
    inode = {found.st_dev, found.st_ino};
    return true;
}

}  // namespace

RunOutputs::RunOutputs() {
    const std::lock_guard<std::mutex> hold(runLock);
    run = std::make_unique<Run>();
}

RunOutputs::~RunOutputs() {
    const std::lock_guard<std::mutex> hold(runLock);
    for (const Waiting& output : run->waiting) removeTemporary(output.temporary);
    std::error_code notEmpty;
    for (auto folder = run->folders.rbegin(); folder != run->folders.rend(); ++folder) fs::remove(*folder, notEmpty);
    run.reset();
}

void commitRunOutputs() {
    const std::lock_guard<std::mutex> hold(runLock);
    if (!run) return;
    for (const Waiting& output : run->waiting) output.move();
    run->waiting.clear();
    run->folders.clear();
}

void noteOutput(const std::string& target) {
    const std::lock_guard<std::mutex> hold(runLock);
    Inode inode;
    if (run && inodeOf(target, inode)) run->outputs.insert(inode);
}

void noteInput(const std::string& path) {
    const std::lock_guard<std::mutex> hold(runLock);
    Inode inode;
    if (!run || !inodeOf(path, inode)) return;
    if (run->outputs.count(inode) > 0)
        throw IoError("'" + path + "' would be written, but is also read; choose another name for the output");
    run->inputs.insert(inode);
}

void requireNotRead(const std::string& target) {
    const std::lock_guard<std::mutex> hold(runLock);
    Inode inode;
    if (run && inodeOf(target, inode) && run->inputs.count(inode) > 0)
        throw IoError("cannot write '" + target + "': it is one of the files that were read; choose another name");
}

void moveWithRun(const std::function<void()>& move, const std::string& temporary) {
    {
        const std::lock_guard<std::mutex> hold(runLock);
        if (run) {
            run->waiting.push_back({move, temporary});
            return;
        }
    }
    move();
}

void makeOutputFolder(const std::string& folder) {
    std::error_code error;
    std::vector<fs::path> made;
    for (fs::path at = folder; !at.empty() && !fs::exists(at, error) && at != at.parent_path(); at = at.parent_path())
        if (at.has_filename()) made.insert(made.begin(), at);
    fs::create_directories(folder, error);
    {
        const std::lock_guard<std::mutex> hold(runLock);  // some may be there even if the last cannot be made
        if (run) run->folders.insert(run->folders.end(), made.begin(), made.end());
    }
    if (error || !fs::is_directory(folder, error))
        throw IoError("cannot make the folder '" + folder +
                      "': " + (error ? error.message() : "there is a file of that name"));
}

}  // namespace raysweep
