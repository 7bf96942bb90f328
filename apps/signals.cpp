#include "signals.h"

#include "raysweep/core/temporaries.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <thread>

namespace raysweep::apps {
namespace {

volatile std::sig_atomic_t listening = 0, stopRequested = 0;
int toWatcher = -1;

/// A handler may do next to nothing; a thread that waits at the other end of a pipe does the rest.
extern "C" void onSignal(int signal) {
    const int error = errno;
    if (signal == SIGINT && listening && !stopRequested) {
        stopRequested = 1;
    } else {
        const char number = char(signal);
        static_cast<void>(!::write(toWatcher, &number, 1));
    }
    errno = error;
}

void endProcess(int signal) {
    removeTemporariesForGood();
    std::signal(signal, SIG_DFL);
    ::kill(::getpid(), signal);
}

void waitForSignal(int pipe) {
    char signal = 0;
    for (;;) {
        const ssize_t got = ::read(pipe, &signal, 1);
        if (got == 1) endProcess(signal);
        if (got == 0 || (got < 0 && errno != EINTR)) return;
    }
}

}  // namespace

void watchSignals() {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) return;  // then signals do what they do
    toWatcher = ends[1];
    std::thread(waitForSignal, ends[0]).detach();
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
        struct sigaction action = {};
        if (sigaction(signal, nullptr, &action) != 0 || action.sa_handler == SIG_IGN) continue;
        action = {};
        action.sa_handler = onSignal;
        action.sa_flags = SA_RESTART;
        sigaction(signal, &action, nullptr);
    }
}

StopRequests::StopRequests() {
    stopRequested = 0;
    listening = 1;
}

StopRequests::~StopRequests() {
    listening = 0;
}

bool StopRequests::made() {
    return stopRequested != 0;
}

}  // namespace raysweep::apps
