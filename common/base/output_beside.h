// Where results are put: through links, and whole or not at all.
//
// Thread safety: calls for different files are independent.
#pragma once

#include <functional>
#include <iosfwd>
#include <string>

namespace sleight::base {

/// The place that is written where people name `path`: links are followed, so that they stay and
/// what they lead to is replaced, or made. `path` itself where it is no link, without slashes at
/// its end. Throws Error: usage of "-", as whoever takes that for standard output doesn't ask;
/// environment of links that lead in a circle.
std::string where_links_lead(const std::string& path);

/// A file that is written beside its place and renamed when it is whole. A pipe or device is
/// written in place.
class OutputBeside {
 public:
  /// Makes the file beside. Throws Error(environment).
  explicit OutputBeside(const std::string& path);
  OutputBeside(const OutputBeside&) = delete;
  OutputBeside& operator=(const OutputBeside&) = delete;
  /// Removes what has not been put in place.
  ~OutputBeside();

  /// Where to write.
  const std::string& path() const { return beside_.empty() ? place_ : beside_; }
  /// Throws Error(environment) when the file can't be renamed.
  void put_in_place();

 private:
  std::string place_;
  std::string beside_;  ///< empty: written in place, or already put there
};

/// Writes a whole file, as OutputBeside has it; what `write` throws leaves the old one. Throws
/// Error(environment) when it can't be written.
void write_output(const std::string& path, const std::function<void(std::ostream&)>& write);

}  // namespace sleight::base
