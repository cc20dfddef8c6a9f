// Ctrl-C and SIGTERM as a question that a loop asks. The first one asks the run to end in order;
// the second ends the process at once, which loses nothing that was reported as done.
#pragma once

namespace sleight::coordinator {

/// Installs the handlers for SIGINT and SIGTERM. Call once, from the main thread.
void catch_stop_signals();

/// Whether one has come. Async-signal-safe underneath, thread-safe.
bool stop_requested();

}  // namespace sleight::coordinator
