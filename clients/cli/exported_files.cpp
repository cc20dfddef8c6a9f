#include "clients/cli/exported_files.h"

#include <cctype>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <system_error>

#include <fmt/format.h>

#include "clients/browse/index.h"
#include "clients/terminal/interruption.h"
#include "common/base/error.h"
#include "common/base/output_beside.h"

namespace sleight::cli {
namespace {

namespace fs = std::filesystem;

constexpr auto k_progress_every = std::chrono::seconds(1);

/// Whether a file begins like a model that sleight made.
bool is_ours(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string head(96, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  return head.starts_with("glTF") && head.find("\"generator\":\"Sleight\"") != std::string::npos;
}

}  // namespace

std::string export_name(const std::string& run_id, const std::string& id) {
  std::string letters;
  for (const char letter : run_id) {
    if (std::isalnum(static_cast<unsigned char>(letter)) != 0 &&
        letters.size() < browse::k_run_letters)
      letters += letter;
  }
  return fmt::format("{}-{}", letters.empty() ? "run" : letters, id);
}

void make_export_folder(const std::string& given) {
  const std::string path = base::where_links_lead(given);
  std::error_code failed;
  fs::create_directories(path, failed);
  if (!failed && fs::is_directory(path)) return;
  throw base::Error(fmt::format("{}: can't create this folder: {}", path,
                                failed ? failed.message() : "a file with this name exists"));
}

void refuse_others_file(const std::string& path, bool force) {
  std::error_code none;
  // Don't open a pipe: the call would wait for a reader.
  if (fs::exists(path, none) && !fs::is_regular_file(path, none) && !fs::is_directory(path, none))
    throw base::Error(base::ExitCode::conflict,
                      fmt::format("{}: already exists and is not a regular file", path));
  if (force || !fs::is_regular_file(path, none) || is_ours(path)) return;
  throw base::Error(base::ExitCode::conflict,
                    fmt::format("{}: already exists and is not recognised as a file written by "
                                "sleight; to replace it, add --force",
                                path));
}

void ExportProgress::done(std::size_t count, std::size_t frames, std::size_t of) {
  terminal::Interruption::check();
  const auto now = std::chrono::steady_clock::now();
  if (now - told_ < k_progress_every || count == all_) return;
  told_ = now;
  const double part = of == 0 ? 0 : static_cast<double>(frames) / static_cast<double>(of);
  const double finished = static_cast<double>(count) + part;
  std::string left;
  if (finished > 0) {
    const double elapsed_s = std::chrono::duration<double>(now - began_).count();
    left = fmt::format(", {:.0f} s left",
                       std::ceil(elapsed_s / finished * (static_cast<double>(all_) - finished)));
  }
  const std::string in_next = of == 0 ? "" : fmt::format(", frame {} of {}", frames, of);
  fmt::print(stderr, "{} of {} animations{}{}\n", count, all_, in_next, left);
}

}  // namespace sleight::cli
