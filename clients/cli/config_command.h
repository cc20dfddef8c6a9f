// `sleight config`: the settings in effect and the source of each.
#pragma once

namespace sleight::cli {

/// Prints a table, or an object with `json`, and returns the exit code. Throws base::Error(usage)
/// with every error of the environment and the file.
int print_config(bool json);

}  // namespace sleight::cli
