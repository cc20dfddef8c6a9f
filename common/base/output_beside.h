// Writes output files completely or not at all, and follows symbolic links.
//
// Thread safety: calls for different files are independent.
#pragma once

#include <functional>
#include <iosfwd>
#include <string>

namespace sleight::base {

/// Returns the path of the file that must be replaced or created. If `path` is a link, returns the
/// link's target. Otherwise returns `path` without trailing slashes. Throws Error(usage) for "-":
/// callers must not pass standard output to this function. Throws Error(environment) for circular
/// links.
std::string where_links_lead(const std::string& path);

/// A file that is written under a temporary name and renamed when complete. A pipe or device is
/// written directly.
class OutputBeside {
 public:
  /// Creates the temporary file. Throws Error(environment).
  explicit OutputBeside(const std::string& path);
  OutputBeside(const OutputBeside&) = delete;
  OutputBeside& operator=(const OutputBeside&) = delete;
  /// Removes the temporary file unless it was renamed.
  ~OutputBeside();

  const std::string& path() const { return beside_.empty() ? place_ : beside_; }
  /// Throws Error(environment) if the file can't be renamed.
  void put_in_place();

 private:
  std::string place_;
  std::string beside_;  ///< empty: written directly, or already in place
};

/// Writes a whole file with OutputBeside. If `write` throws, the old file remains. Throws
/// Error(environment) if the file can't be written.
void write_output(const std::string& path, const std::function<void(std::ostream&)>& write);

}  // namespace sleight::base
