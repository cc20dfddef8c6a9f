// The command line of an attempt: what a job is started with.
//
// Everything that an attempt reads and writes lies in its job's folder, which is the program's
// working folder: so its command names files alone, and a folder's name can hold any character.
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
/// Open MPI's own files: session folders and the memory that ranks share.
inline constexpr const char* k_mpi_folder_name = "mpi";

struct AttemptSpec {
  std::string folder{};       ///< the job's, an absolute path; has k_request_name
  std::uint32_t attempt = 1;  ///< from 1
  std::uint32_t cores = 1;    ///< threads; of no meaning with ranks
  std::uint32_t ranks = 0;    ///< of one core each; 0: no MPI is started
  /// In a batch system's job, on the machines that it was given: ranks are spread over them, and
  /// what this machine has does not count.
  bool in_batch = false;
  std::uint64_t cache_mb = 256;  ///< of each process
  bool strict = false;           ///< a simulation that fails ends the run
  /// How long a program may linger that has told its end, and mpirun without ranks. A run waits up
  /// to 20 s for ranks that don't answer, after it has told its end.
  double grace_s = 30;

  bool operator==(const AttemptSpec&) const = default;
};

/// Absolute paths.
struct Programs {
  std::string keeper{};  ///< sleight-keeper
  std::string sleight{};
  std::string sleight_batch{};
  std::string mpirun{};  ///< empty: there is none
};

/// Those beside the running program, and mpirun by PATH.
Programs programs_beside_this();

/// Why the spec can't be run here; empty: it can.
std::string obstacle_of(const AttemptSpec& spec, const Programs& programs);

/// What the keeper starts, as it would be typed in the job's folder.
std::vector<std::string> command_of(const AttemptSpec& spec, const Programs& programs);

/// The keeper's own command, which holds the other.
std::vector<std::string> keeper_command_of(const AttemptSpec& spec, const Programs& programs);

/// What the program gets of an environment: all but what would change how Open MPI or the dynamic
/// linker work (OMPI_*, PMIX_*, LD_* and their like), and a batch job's own variables, by which
/// mpirun would look for that job's nodes. The pair that lets root use mpirun stays.
std::vector<std::string> cleaned_environment(const std::vector<std::string>& environment);

/// This process's, as it is.
std::vector<std::string> whole_environment();

/// This process's, so cleaned.
std::vector<std::string> program_environment();

}  // namespace sleight::keeper
