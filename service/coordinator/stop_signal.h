// Turns Ctrl-C, SIGTERM and SIGUSR1 into a flag that a loop polls. The first signal requests a
// clean end of the run. A later signal ends the process at once. Results that were reported as done
// aren't lost. A signal soon after the first is an echo: batch systems signal both mpirun and the
// ranks, and mpirun forwards its signal to the ranks.
//
// SIGUSR1 is for batch systems. On SIGTERM, mpirun ends the job. On SIGUSR1, mpirun only forwards
// the signal, so the run has enough time to stop (`sbatch --signal=B:USR1@60`).
#pragma once

namespace sleight::coordinator {

/// If a signal follows the first within this time, it counts as an echo.
inline constexpr double k_echo_s = 0.5;

/// Installs the signal handlers. Call once, from the main thread.
void catch_stop_signals();

/// Call in ranks other than 0, which exit when rank 0 requests it.
void ignore_stop_signals();

/// Returns whether a stop signal has arrived. Thread-safe.
bool stop_requested();

}  // namespace sleight::coordinator
