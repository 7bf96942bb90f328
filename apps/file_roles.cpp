#include "file_roles.h"

#include "cli.h"

#include "raysweep/core/run_outputs.h"
#include "raysweep/core/target_path.h"

#include <map>
#include <utility>

namespace raysweep::apps {
namespace {

enum class Kind { input, output, folder, replacedFolder };

struct Role {
    Kind kind;
    FileNames names;
    std::function<bool(const std::string&)> isFolder = {};  ///< true for values that stand for a replaced folder
};

/// A file or folder that the command was given.
struct Named {
    std::string option, path;
    Kind kind;
    FileIdentity identity;
};

/// Options live as long as the program.
std::map<const CLI::Option*, Role>& roles() {
    static std::map<const CLI::Option*, Role> all;
    return all;
}

CLI::Option* withRole(CLI::Option* option, Kind kind, FileNames names) {
    roles()[option] = {kind, std::move(names), {}};
    return option;
}

std::string nameOf(const CLI::Option& option) {
    return option.get_name();
}

void add(std::vector<Named>& files, const CLI::Option& option, const Role& role) {
    for (const std::string& value : option.results())
        for (const std::string& path : role.names ? role.names(value) : std::vector<std::string>{value})
            if (!path.empty())
                files.push_back({nameOf(option), path,
                                 role.isFolder && role.isFolder(path) ? Kind::replacedFolder : role.kind,
                                 FileIdentity(path)});
}

std::vector<Named> filesOf(const CLI::App& command) {
    std::vector<Named> files;
    for (const CLI::Option* option : command.get_options()) {
        const auto role = roles().find(option);
        if (role != roles().end()) add(files, *option, role->second);
    }
    const CLI::App* const program = command.get_parent();
    if (const CLI::Option* config = program ? program->get_config_ptr() : nullptr)
        for (const std::string& path : config->results())
            files.push_back({"--config", path, Kind::input, FileIdentity(path)});
    return files;
}

bool isFolder(const Named& file) {
    return file.kind == Kind::folder || file.kind == Kind::replacedFolder;
}

[[noreturn]] void refuse(const Named& output, const Named& other) {
    const std::string also =
        other.option == output.option ? "also names that file"
        : output.identity == other.identity
            ? "is also " + other.option + (other.path == output.path ? "" : " '" + other.path + "'")
            : "holds '" + other.path + "' (" + other.option + ")";
    usageError(output.option, "'" + output.path + "' would be written, but " + also + "; choose another name");
}

/// Refuses a name that is there twice, unless it is only read. There may be thousands, of a series.
void requireDifferent(const std::vector<Named>& files) {
    std::map<FileIdentity, const Named*> seen;
    for (const Named& file : files) {
        const auto [other, isNew] = seen.emplace(file.identity, &file);
        if (isNew) continue;
        if (file.kind != Kind::input) refuse(file, *other->second);
        if (other->second->kind != Kind::input) refuse(*other->second, file);
    }
}

/// Refuses a folder that is filled where something that is read lies in it, or anything if all that is in it goes.
void requireNothingWithin(const Named& folder, const std::vector<Named>& files) {
    for (const Named& other : files)
        if ((other.kind == Kind::input || folder.kind == Kind::replacedFolder) &&
            other.identity.isWithin(folder.identity))
            refuse(folder, other);
}

/// Text that is not given is no value: it would be taken for 0, or for an option that was left out.
void requireValues(const CLI::App& command) {
    for (const CLI::Option* option : command.get_options())
        for (const std::string& value : option->results())
            if (option->get_type_size() > 0 && value.find_first_not_of(" \t\r\n") == std::string::npos)
                usageError(nameOf(*option), "its value is empty; leave the option out or give one");
}

}  // namespace

CLI::Option* reads(CLI::Option* option, FileNames names) {
    return withRole(option, Kind::input, std::move(names));
}

CLI::Option* writes(CLI::Option* option, FileNames names) {
    return withRole(option, Kind::output, std::move(names));
}

CLI::Option* fills(CLI::Option* option, bool replaced) {
    return withRole(option, replaced ? Kind::replacedFolder : Kind::folder, {});
}

CLI::Option* writesOrFills(CLI::Option* option, std::function<bool(const std::string&)> isFolder) {
    roles()[option] = {Kind::output, {}, std::move(isFolder)};
    return option;
}

void requireFilesApart(const CLI::App& command) {
    requireValues(command);
    const std::vector<Named> files = filesOf(command);
    requireDifferent(files);
    for (const Named& file : files) {
        if (isFolder(file)) requireNothingWithin(file, files);
        if (file.kind == Kind::output) noteOutput(file.path);
    }
}

}  // namespace raysweep::apps
