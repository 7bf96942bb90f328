#include "raysweep/core/temporaries.h"

#include "raysweep/core/error.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <random>
#include <set>

namespace fs = std::filesystem;

namespace raysweep {
namespace {

struct Registry {
    std::mutex lock;
    std::set<std::string> paths;
};

Registry& registry() {
    static auto* const all = new Registry;  // never destroyed: the process may end while threads write
    return *all;
}

std::string randomName(const std::string& extension) {
    constexpr char kLetters[] = "abcdefghijklmnopqrstuvwxyz012345";
    constexpr int kCount = 16;
    constexpr std::size_t kLongest = 16;
    std::random_device source;
    std::string name = ".raysweep-";
    for (int n = 0; n < kCount; ++n) name += kLetters[source() % (sizeof kLetters - 1)];
    return name + ".part" + (extension.size() <= kLongest ? extension : "");
}

/// Calls `make(path)`, which returns false with errno set, for new names until one is not taken.
template <class Make>
std::string makeNew(const std::string& folder, const std::string& extension, const Make& make) {
    constexpr int kTries = 100;
    Registry& all = registry();
    const std::lock_guard<std::mutex> hold(all.lock);
    for (int tries = 0; tries < kTries; ++tries) {
        const std::string path = (fs::path(folder) / randomName(extension)).string();
        if (make(path)) return *all.paths.insert(path).first;
        if (errno != EEXIST) break;
    }
    throw IoError(std::strerror(errno));
}

void removeAll(const std::string& path) {
    std::error_code ignored;
    fs::remove_all(path, ignored);
}

}  // namespace

std::string makeTemporaryFile(const std::string& folder, const std::string& extension, int& descriptor) {
    return makeNew(folder, extension, [&](const std::string& path) {
        descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, S_IRUSR | S_IWUSR);
        return descriptor >= 0;
    });
}

std::string makeTemporaryFolder(const std::string& folder) {
    return makeNew(folder, "",
                   [](const std::string& path) { return ::mkdir(path.c_str(), S_IRWXU | S_IRWXG | S_IRWXO) == 0; });
}

int moveTemporary(const std::string& temporary, const std::string& target) {
    Registry& all = registry();
    const std::lock_guard<std::mutex> hold(all.lock);
    if (std::rename(temporary.c_str(), target.c_str()) != 0) return errno;
    all.paths.erase(temporary);
    return 0;
}

int exchangeTemporary(const std::string& temporary, const std::string& target) {
    const std::lock_guard<std::mutex> hold(registry().lock);
    if (::renameat2(AT_FDCWD, temporary.c_str(), AT_FDCWD, target.c_str(), RENAME_EXCHANGE) == 0) return 0;
    // Some file systems cannot, networks' for instance: then there is no target for a moment.
    const std::string aside = temporary + ".old";  // not of those that are removed when the process ends
    if (std::rename(target.c_str(), aside.c_str()) != 0) return errno;
    if (std::rename(temporary.c_str(), target.c_str()) != 0) {
        const int why = errno;
        return std::rename(aside.c_str(), target.c_str()) == 0 ? why : errno;
    }
    return std::rename(aside.c_str(), temporary.c_str()) == 0 ? 0 : errno;
}

void removeTemporary(const std::string& temporary) {
    Registry& all = registry();
    const std::lock_guard<std::mutex> hold(all.lock);
    if (all.paths.erase(temporary) > 0) removeAll(temporary);
}

void removeTemporariesForGood() {
    Registry& all = registry();
    all.lock.lock();
    for (const std::string& path : all.paths) removeAll(path);
}

}  // namespace raysweep
