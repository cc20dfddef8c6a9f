// What runs a daemon's jobs where this machine doesn't: Slurm, or a program's system.
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
  std::string script{};                         ///< direct.sbatch, of slurm
};

/// As the settings say. Throws base::Error(usage), which names the setting.
System system_of(const config::Settings& settings);

/// Why a job's options are no good there. Throws base::Error(usage).
void check_options(const config::Settings& settings,
                   const std::map<std::string, std::string>& options);

}  // namespace sleight::programs
