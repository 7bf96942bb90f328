/// Messages and the progress bar: all that goes to stderr.
#include "cli.h"

#include <unistd.h>
#include <cerrno>

#include <algorithm>
#include <cstdio>

namespace raysweep::apps {
namespace {

bool isTerminal() {
    return ::isatty(STDERR_FILENO) != 0;
}

void clearLine() {
    std::fputs("\r\x1b[K", stderr);
}

void say(const std::string& text) {
    if (isTerminal()) clearLine();
    std::fprintf(stderr, "%s: %s\n", program_invocation_short_name, text.c_str());
}

std::string timeLeft(double elapsed, double fraction) {
    if (elapsed < 1 || fraction < 0.01) return "";
    const int seconds = int(std::min(359999.0, elapsed * (1 - fraction) / fraction + 0.5));
    char text[32];
    if (seconds >= 3600)
        std::snprintf(text, sizeof text, "%d:%02d:%02d left", seconds / 3600, seconds / 60 % 60, seconds % 60);
    else
        std::snprintf(text, sizeof text, "%d:%02d left", seconds / 60, seconds % 60);
    return text;
}

}  // namespace

void message(const CommonOptions& options, const std::string& text) {
    if (!options.quiet) say(text);
}

void warning(const CommonOptions& options, const std::string& text) {
    message(options, "warning: " + text);
}

void detail(const CommonOptions& options, const std::string& text) {
    if (options.verbose) message(options, text);
}

TerminalProgress::TerminalProgress(const CommonOptions& options) : drawing_(!options.quiet && isTerminal()) {}

TerminalProgress::~TerminalProgress() {
    if (lastDrawn_ >= 0) clearLine();
}

bool TerminalProgress::interrupted() {
    return StopRequests::made();
}

ProgressCallback TerminalProgress::callback() {
    return [this](const std::string& stage, double fraction) {
        if (drawing_) draw(stage, fraction);
        return !interrupted();
    };
}

void TerminalProgress::draw(const std::string& stage, double fraction) {
    const double now = timer_.seconds();
    // "stage: detail": the detail changes all the time.
    const std::size_t colon = stage.find(": ");
    const std::string name = stage.substr(0, colon);
    const std::string aside = colon == std::string::npos ? "" : "  " + stage.substr(colon + 2);
    if (name != stage_) {
        stage_ = name;
        stageStart_ = now;
    } else if (now - lastDrawn_ < 0.1) {
        return;
    }
    lastDrawn_ = now;
    constexpr int kWidth = 30;
    fraction = std::clamp(fraction, 0.0, 1.0);
    const int full = int(fraction * kWidth + 0.5);
    const std::string bar = std::string(std::size_t(full), '#') + std::string(std::size_t(kWidth - full), '.');
    clearLine();
    std::fprintf(stderr, "%-12s [%s] %3d%%  %s%s", name.c_str(), bar.c_str(), int(fraction * 100),
                 timeLeft(now - stageStart_, fraction).c_str(), aside.c_str());
    std::fflush(stderr);
}

}  // namespace raysweep::apps
