/// What Ctrl-C, the end of a terminal and a polite kill do.
#pragma once

namespace raysweep::apps {

/// From now on SIGINT, SIGTERM and SIGHUP remove the temporaries of files that are being written before they end the
/// process; signals that are ignored stay so (nohup, commands in the background). Call it once, before any thread is
/// started.
void watchSignals();

/// While one of these lives, the first Ctrl-C only asks the work to stop; another one ends the process.
class StopRequests {
  public:
    StopRequests();
    ~StopRequests();
    StopRequests(const StopRequests&) = delete;
    StopRequests& operator=(const StopRequests&) = delete;

    /// True once Ctrl-C was pressed while the last of these lived, also after it.
    static bool made();
};

}  // namespace raysweep::apps
