// Results that reach their place, or an error that says so: a full disk or a closed stdout must not
// look like success.
#pragma once

#include <functional>
#include <string>

#include "common/base/error.h"

namespace sleight::cli {

inline constexpr int k_ok = static_cast<int>(base::ExitCode::ok);

/// Throws base::Error(usage).
[[noreturn]] void refuse_usage(const std::string& words);

/// Writes out what waits for stdout. Throws base::Error(environment) when that, or any earlier
/// print, failed.
void flush_stdout();

/// Runs `work`, which prints to stdout, then flush_stdout; returns what `work` returns. Failed
/// prints inside `work` become the same base::Error(environment).
int with_results(const std::function<int()>& work);

/// Opens the standard streams that the caller closed, so that writing to them still fails, but no
/// file or pipe of ours takes their place; and a limit on the size of files fails a write like a
/// full disk, instead of ending the process. Called first of all.
void occupy_standard_streams();

/// Throws base::Error(usage) when writing `output` would replace `archive`: the same file by
/// whatever path or link.
void refuse_same_file(const std::string& archive, const std::string& output);

}  // namespace sleight::cli
