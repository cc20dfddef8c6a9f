#include "common/base/output_beside.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "common/base/descriptor.h"
#include "common/base/error.h"

namespace sleight::base {
namespace {

namespace fs = std::filesystem;

/// The system's own limit.
constexpr int k_links_max = 40;

[[noreturn]] void fail_to_write(const std::string& place, const std::error_code& reason) {
  throw Error(fmt::format("{}: can't write: {}", place, reason.message()));
}

}  // namespace

std::string where_links_lead(const std::string& path) {
  if (path == "-")
    throw Error(ExitCode::usage,
                "-: can't write this output to standard output; name a file or folder");
  fs::path place(path);
  while (!place.has_filename() && place.has_relative_path())
    place = place.parent_path();
  for (int links = 0; links < k_links_max; ++links) {
    std::error_code is_none;
    const fs::path target = fs::read_symlink(place, is_none);
    if (is_none) return place.string();
    place = place.parent_path() / target;  // an absolute target replaces the path
  }
  fail_to_write(path, std::make_error_code(std::errc::too_many_symbolic_link_levels));
}

OutputBeside::OutputBeside(const std::string& path) : place_(where_links_lead(path)) {
  std::error_code none;
  if (fs::exists(place_, none) && !fs::is_regular_file(place_, none)) return;
  beside_ = fmt::format("{}.tmp.{}", place_, ::getpid());
  // If a file of this name exists, remove it: a killed process left it, or the file is a trap.
  ::unlink(beside_.c_str());
  const Descriptor made(
      ::open(beside_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0666));
  if (!made) fail_to_write(place_, std::error_code(errno, std::generic_category()));
}

OutputBeside::~OutputBeside() {
  if (!beside_.empty()) ::unlink(beside_.c_str());
}

void OutputBeside::put_in_place() {
  if (beside_.empty()) return;
  if (std::rename(beside_.c_str(), place_.c_str()) != 0)
    fail_to_write(place_, std::error_code(errno, std::generic_category()));
  beside_.clear();
}

void write_output(const std::string& path, const std::function<void(std::ostream&)>& write) {
  OutputBeside output(path);
  errno = 0;
  std::ofstream file(output.path(), std::ios::binary);
  if (file) {
    write(file);
    file.close();
  }
  if (!file) {
    fail_to_write(path, errno == 0 ? std::make_error_code(std::errc::no_space_on_device)
                                   : std::error_code(errno, std::generic_category()));
  }
  output.put_in_place();
}

}  // namespace sleight::base
