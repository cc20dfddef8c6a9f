#include "service/keeper/command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "common/base/cores.h"

namespace sleight::keeper {
namespace {

/// Returns the first executable file of this name on PATH.
std::string found_on_path(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::string_view rest = path == nullptr ? "/usr/bin:/bin" : path;
  while (true) {
    const std::size_t end = rest.find(':');
    const std::string folder(rest.substr(0, end));
    const std::string file = folder + "/" + name;
    if (folder.starts_with('/') && ::access(file.c_str(), X_OK) == 0) return file;
    if (end == std::string_view::npos) return {};
    rest.remove_prefix(end + 1);
  }
}

/// Returns an mpirun command for this machine only. mpirun uses only the loopback network, and Open
/// MPI writes no files outside the folder. Ranks aren't bound to cores. Otherwise each mpirun would
/// bind its ranks to the same first cores.
std::vector<std::string> mpirun_of(const AttemptSpec& spec, const Programs& programs) {
  // In a batch system's job, mpirun gets the list of machines from that system. The site configures
  // this.
  if (spec.in_batch)
    return {programs.mpirun.empty() ? "mpirun" : programs.mpirun, "-n",
            fmt::format("{}", spec.ranks), programs.sleight_batch};
  const std::string files = spec.folder + "/" + k_mpi_folder_name;
  std::vector<std::string> command{programs.mpirun, "--bind-to", "none"};
  for (const auto& [name, value] : {std::pair<std::string, std::string>{"plm", "isolated"},
                                    {"btl", "self,vader"},
                                    {"oob_tcp_if_include", "lo"},
                                    {"orte_tmpdir_base", files},
                                    {"btl_vader_backing_directory", files}}) {
    command.insert(command.end(), {"--mca", name, value});
  }
  command.insert(command.end(), {"-n", fmt::format("{}", spec.ranks), programs.sleight_batch});
  return command;
}

}  // namespace

Programs programs_beside_this() {
  std::error_code error;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string folder = self.parent_path().string();
  return {.keeper = folder + "/sleight-keeper",
          .sleight = folder + "/sleight",
          .sleight_batch = folder + "/sleight-batch",
          .mpirun = found_on_path("mpirun")};
}

std::string obstacle_of(const AttemptSpec& spec, const Programs& programs) {
  if (!spec.folder.starts_with('/')) return "the job's folder must be an absolute path";
  if (spec.ranks == 0 || spec.in_batch) return {};
  if (programs.mpirun.empty()) {
    return "mpirun is not on the PATH; install Open MPI, or submit the job without --ranks";
  }
  const std::uint32_t cores = base::cores_here();
  if (spec.ranks > cores)
    return fmt::format("{} ranks need more than this machine's {} cores", spec.ranks, cores);
  return {};
}

std::vector<std::string> command_of(const AttemptSpec& spec, const Programs& programs) {
  std::vector<std::string> command;
  if (spec.ranks > 0) {
    command = mpirun_of(spec, programs);
    command.insert(command.end(), {k_request_name, "-o", k_output_name});
  } else {
    command = {programs.sleight,
               "direct",
               k_request_name,
               "-o",
               k_output_name,
               "-j",
               fmt::format("{}", spec.cores)};
  }
  command.insert(command.end(), {"--cache", fmt::format("{}", spec.cache_mb), "--end-report",
                                 k_pipe_name, "--quiet"});
  if (spec.strict) command.emplace_back("--strict");
  return command;
}

std::vector<std::string> keeper_command_of(const AttemptSpec& spec, const Programs& programs) {
  std::vector<std::string> command{programs.keeper,
                                   "--folder",
                                   spec.folder,
                                   "--attempt",
                                   fmt::format("{}", spec.attempt),
                                   "--grace",
                                   fmt::format("{}", spec.grace_s)};
  if (spec.ranks > 0) command.emplace_back("--ranks");
  if (spec.in_batch) command.emplace_back("--batch");
  command.emplace_back("--");
  const std::vector<std::string> kept = command_of(spec, programs);
  command.insert(command.end(), kept.begin(), kept.end());
  return command;
}

std::vector<std::string> cleaned_environment(const std::vector<std::string>& environment) {
  constexpr std::array<std::string_view, 8> dropped{"OMPI_", "ORTE_", "OPAL_",  "PMIX_",
                                                    "PMI_",  "LD_",   "SLURM_", "PBS_"};
  constexpr std::string_view kept = "OMPI_ALLOW_RUN_AS_ROOT";
  std::vector<std::string> cleaned;
  for (const std::string& variable : environment) {
    bool drops = false;
    for (const std::string_view prefix : dropped)
      drops = drops || variable.starts_with(prefix);
    if (!drops || variable.starts_with(kept)) cleaned.push_back(variable);
  }
  return cleaned;
}

std::vector<std::string> whole_environment() {
  std::vector<std::string> variables;
  for (char** variable = environ; *variable != nullptr; ++variable)
    variables.emplace_back(*variable);
  return variables;
}

std::vector<std::string> program_environment() {
  return cleaned_environment(whole_environment());
}

}  // namespace sleight::keeper
