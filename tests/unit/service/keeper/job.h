// A job's folder whose program is a shell script, under real keepers.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "service/keeper/backend.h"

namespace sleight::keeper::testing {

class JobTest : public ::testing::Test {
 protected:
  JobTest();
  ~JobTest() override;  ///< ends what the test left

  const std::string& folder() const { return folder_; }
  std::string path(const std::string& name) const { return folder_ + "/" + name; }

  /// Makes a script that stands for `sleight`, or with ranks for mpirun.
  void program_is(const std::string& script);
  /// With the real keeper, or one that dies at SLEIGHT_KEEPER_DIES_AT.
  LocalBackend backend(bool dies = false) const;
  AttemptSpec spec(std::uint32_t attempt = 1) const;

  /// Waits as a daemon does until the attempt is not running; fails the test after 20 s.
  Look await_end(std::uint32_t attempt = 1) const;
  /// Launches the script and waits for its end, which must be recorded.
  AttemptEnd run(const AttemptSpec& spec) const;
  AttemptEnd run() const { return run(spec()); }

  std::string text_in(const std::string& name) const;
  std::vector<std::string> lines_in(const std::string& name) const;
  /// Waits until the file is there with a whole line; fails the test after 20 s.
  void await_file(const std::string& name) const;

 private:
  std::string folder_;
};

/// Asks again and again, for 20 s at most.
bool comes_true(const std::function<bool()>& question);

/// Processes of whose command line `words` is a part.
std::vector<pid_t> processes_with(const std::string& words);

}  // namespace sleight::keeper::testing
