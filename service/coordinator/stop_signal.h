// Ctrl-C, SIGTERM and SIGUSR1 as a flag that a loop polls. The first signal requests a clean end of
// the run. A later one ends the process at once, without losing anything reported as done. A signal
// soon after the first is an echo: batch systems signal mpirun and the ranks, and mpirun passes it
// on.
//
// SIGUSR1 is for batch systems. mpirun ends the job on SIGTERM, but only passes SIGUSR1 on, so the
// run has enough time (`sbatch --signal=B:USR1@60`).
#pragma once

namespace sleight::coordinator {

/// A signal this soon after the first is its echo.
inline constexpr double k_echo_s = 0.5;

/// Installs the handlers. Call once, from the main thread.
void catch_stop_signals();

/// For ranks whose rank 0 tells them when to exit.
void ignore_stop_signals();

/// Whether a stop signal has arrived. Thread-safe.
bool stop_requested();

}  // namespace sleight::coordinator
