// `sleight config`: the settings that hold and what gave each.
#pragma once

namespace sleight::cli {

/// A table, or with `json` an object, on stdout; the exit code. Throws base::Error(usage) with
/// every error of the environment and the file.
int print_config(bool json);

}  // namespace sleight::cli
