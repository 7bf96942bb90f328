#include "file_roles.h"

#include "cli.h"

#include "raysweep/core/target_path.h"

#include <map>
#include <utility>

namespace raysweep::apps {
namespace {

enum class Kind { input, output, folder, replacedFolder };

struct Role {
    Kind kind;
    FileNames names;
};

/// A file or folder that the command was given.
struct Named {
    std::string option, path;
    Kind kind;
};

/// Options live as long as the program.
std::map<const CLI::Option*, Role>& roles() {
    static std::map<const CLI::Option*, Role> all;
    return all;
}

CLI::Option* withRole(CLI::Option* option, Kind kind, FileNames names) {
    roles()[option] = {kind, std::move(names)};
    return option;
}

std::string nameOf(const CLI::Option& option) {
    return option.get_name();
}

void add(std::vector<Named>& files, const CLI::Option& option, const Role& role) {
    for (const std::string& value : option.results())
        for (const std::string& path : role.names ? role.names(value) : std::vector<std::string>{value})
            if (!path.empty()) files.push_back({nameOf(option), path, role.kind});
}

std::vector<Named> filesOf(const CLI::App& command) {
    std::vector<Named> files;
    for (const CLI::Option* option : command.get_options()) {
        const auto role = roles().find(option);
        if (role != roles().end()) add(files, *option, role->second);
    }
    const CLI::App* const program = command.get_parent();
    if (const CLI::Option* config = program ? program->get_config_ptr() : nullptr)
        for (const std::string& path : config->results()) files.push_back({"--config", path, Kind::input});
    return files;
}

bool isFolder(const Named& file) {
    return file.kind == Kind::folder || file.kind == Kind::replacedFolder;
}

/// What is written to `output` would harm `other`.
bool harms(const Named& output, const Named& other) {
    if (sameFile(output.path, other.path)) return true;
    if (!isFolder(output)) return false;
    return (other.kind == Kind::input || output.kind == Kind::replacedFolder) && isWithin(other.path, output.path);
}

void requireApart(const Named& output, const Named& other) {
    if (!harms(output, other)) return;
    const std::string also =
        other.option == output.option ? "also names that file"
        : isFolder(output) && !sameFile(output.path, other.path)
            ? "holds '" + other.path + "' (" + other.option + ")"
            : "is also " + other.option + (other.path == output.path ? "" : " '" + other.path + "'");
    usageError(output.option, "'" + output.path + "' would be written, but " + also + "; choose another name");
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

void requireFilesApart(const CLI::App& command) {
    requireValues(command);
    const std::vector<Named> files = filesOf(command);
    for (std::size_t n = 0; n < files.size(); ++n)
        for (std::size_t other = 0; other < files.size(); ++other) {
            const bool once = files[other].kind == Kind::input || isFolder(files[n]) || other < n;
            if (other != n && files[n].kind != Kind::input && once) requireApart(files[n], files[other]);
        }
}

}  // namespace raysweep::apps
