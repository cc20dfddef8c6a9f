// Command lines of attempts.
//
// An attempt reads and writes only its job's folder. The job's folder is also the program's working
// folder. So commands contain only file names, and the folder's name can contain any character.
//
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sleight::keeper {

/// Names in a job's folder.
inline constexpr const char* k_request_name = "request.toml";
inline constexpr const char* k_output_name = "out.h5";
inline constexpr const char* k_lock_name = "keeper.lock";
inline constexpr const char* k_pipe_name = "end.pipe";
inline constexpr const char* k_log_name = "log";
inline constexpr const char* k_old_log_name = "log.old";
inline constexpr const char* k_keeper_words_name = "keeper.err";
/// Open MPI's own files: session folders and the ranks' shared memory.
inline constexpr const char* k_mpi_folder_name = "mpi";

struct AttemptSpec {
  std::string folder{};       ///< the job's folder, an absolute path; contains k_request_name
  std::uint32_t attempt = 1;  ///< from 1
  std::uint32_t cores = 1;    ///< threads; ignored with ranks
  std::uint32_t ranks = 0;    ///< one core each; 0: without MPI
  /// The attempt runs in a batch system's job. Ranks are spread over that job's machines, so the
  /// number of this machine's cores doesn't matter.
  bool in_batch = false;
  std::uint64_t cache_mb = 256;  ///< per process
  bool strict = false;           ///< a failed simulation ends the run
  /// A program that has reported its end must exit within this time. When mpirun's last rank has
  /// exited, mpirun must exit within this time or 10 s, whichever is shorter. A run that has
  /// reported its end waits up to 20 s for ranks that don't answer.
  double grace_s = 30;

  bool operator==(const AttemptSpec&) const = default;
};

/// Absolute paths.
struct Programs {
  std::string keeper{};  ///< sleight-keeper
  std::string sleight{};
  std::string sleight_batch{};
  std::string mpirun{};  ///< empty: not installed
};

/// Finds mpirun on PATH, and the other programs in the running program's folder.
Programs programs_beside_this();

/// Returns why the spec can't run here. Empty: it can.
std::string obstacle_of(const AttemptSpec& spec, const Programs& programs);

/// Returns the program's command, to be run in the job's folder.
std::vector<std::string> command_of(const AttemptSpec& spec, const Programs& programs);

/// Returns the keeper's command. It contains the program's command.
std::vector<std::string> keeper_command_of(const AttemptSpec& spec, const Programs& programs);

/// The environment for programs. Removes variables that would change Open MPI or the dynamic linker
/// (OMPI_*, PMIX_*, LD_* and similar). Also removes a batch job's variables: mpirun would search
/// for that job's nodes. Keeps the two variables that allow root to use mpirun.
std::vector<std::string> cleaned_environment(const std::vector<std::string>& environment);

/// This process's environment, unchanged.
std::vector<std::string> whole_environment();

/// This process's environment, cleaned.
std::vector<std::string> program_environment();

}  // namespace sleight::keeper
