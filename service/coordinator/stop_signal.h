// Ctrl-C, SIGTERM and SIGUSR1 as a question that a loop asks. The first one asks the run to end in
// order; a later one ends the process at once, which loses nothing that was reported as done. One
// that comes right after another is the same one: batch systems signal mpirun, which passes it on,
// and the ranks as well.
//
// SIGUSR1 is for batch systems: unlike SIGTERM, of which it makes an end of its own, mpirun only
// passes it on, so that the run has the time that it needs (`sbatch --signal=B:USR1@60`).
#pragma once

namespace sleight::coordinator {

/// What comes so soon after a first one is an echo of it.
inline constexpr double k_echo_s = 0.5;

/// Installs the handlers. Call once, from the main thread.
void catch_stop_signals();

/// For ranks that another one tells when to end.
void ignore_stop_signals();

/// Whether one has come. Async-signal-safe underneath, thread-safe.
bool stop_requested();

}  // namespace sleight::coordinator
