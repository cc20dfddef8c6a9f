// Selects the system that runs a daemon's jobs: this machine, Slurm, or a system with its own
// program.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "common/config/settings.h"
#include "service/backend/backend.h"

namespace sleight::programs {

struct System {
  std::shared_ptr<backend::Backend> backend{};  ///< null: this machine
  std::string name{};                           ///< "local", "slurm", or the program's path
  std::string script{};                         ///< path of direct.sbatch for slurm
};

/// Returns the system that the settings select. Throws base::Error(usage) that names an invalid
/// setting.
System system_of(const config::Settings& settings);

/// Throws base::Error(usage) if the system doesn't support a job's options.
void check_options(const config::Settings& settings,
                   const std::map<std::string, std::string>& options);

}  // namespace sleight::programs
