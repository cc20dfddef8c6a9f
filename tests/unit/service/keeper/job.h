// A folder of a job, for tests with real keepers. The job's program is a shell script.
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
  ~JobTest() override;  ///< kills the test's remaining processes

  const std::string& folder() const { return folder_; }
  std::string path(const std::string& name) const { return folder_ + "/" + name; }

  /// Creates a script that runs in place of `sleight`. If there are ranks, the script runs in place
  /// of mpirun.
  void program_is(const std::string& script);
  /// Returns a backend that starts the real keeper. If `dies` is true, the keeper dies at
  /// SLEIGHT_KEEPER_DIES_AT.
  LocalBackend backend(bool dies = false) const;
  AttemptSpec spec(std::uint32_t attempt = 1) const;

  /// Like a daemon, waits until the attempt has ended. Fails the test after 20 s.
  Look await_end(std::uint32_t attempt = 1) const;
  /// Launches the script and returns its recorded end.
  AttemptEnd run(const AttemptSpec& spec) const;
  AttemptEnd run() const { return run(spec()); }

  std::string text_in(const std::string& name) const;
  std::vector<std::string> lines_in(const std::string& name) const;
  /// Waits until the file contains a complete line; fails the test after 20 s.
  void await_file(const std::string& name) const;

 private:
  std::string folder_;
};

/// Polls until question() is true, for at most 20 s.
bool comes_true(const std::function<bool()>& question);

/// Returns the processes whose command line contains `words`.
std::vector<pid_t> processes_with(const std::string& words);

}  // namespace sleight::keeper::testing
