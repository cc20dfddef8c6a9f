// `sleight config`: the settings in effect and the source of each.
#pragma once

namespace sleight::cli {

/// Prints a table (with `json`: an object) and returns the exit code. Throws base::Error(usage)
/// that lists every error in the environment and the file.
int print_config(bool json);

}  // namespace sleight::cli
