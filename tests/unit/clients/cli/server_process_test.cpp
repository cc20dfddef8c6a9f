// Goal: the command that starts a background server waits until the server answers. If the server
// can't start, the command reports the reason. Method: start small scripts in place of the server.
#include "clients/service_client/server_process.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <string>
#include <thread>

#include "clients/cli/server_commands.h"
#include "common/base/file_system.h"
#include "scripted_service.h"

namespace sleight::cli {
namespace {

bool ends(service_client::ServerProcess& process) {
  for (int i = 0; i < 1000 && process.is_running(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return !process.is_running();
}

TEST(ServerProcess, LeavesItsWordsInTheLog) {
  // Goal: if the daemon exits at once, the error contains the daemon's exit code and this start's
  // log lines. Only the owner can open the state folder. Method: start two shells in place of the
  // daemon, one after the other.
  const ScratchFolder scratch;
  const std::string folder = scratch / "deep/state";
  service_client::ServerProcess first({"/bin/sh", "-c", "echo first; exit 0"}, folder);
  ASSERT_TRUE(ends(first));
  EXPECT_EQ(first.exit_code(), base::ExitCode::environment) << "an end is no success";
  service_client::ServerProcess second(
      {"/bin/sh", "-c", "echo one; echo two >&2; echo three; exit 4"}, folder);
  ASSERT_TRUE(ends(second));
  EXPECT_EQ(second.exit_code(), base::ExitCode::conflict);
  EXPECT_EQ(second.log_lines(2), (std::vector<std::string>{"two", "three"}));
  EXPECT_EQ(base::read_text_file(folder + "/server.log", 1000), "first\none\ntwo\nthree\n");
  struct stat state {};
  ASSERT_EQ(::stat(folder.c_str(), &state), 0);
  EXPECT_EQ(state.st_mode & 0777U, 0700U);
}

TEST(ServerProcess, IsASessionOfItsOwnWithNothingInherited) {
  // Goal: the daemon has its own session and inherits no descriptor. Method: open a pipe. In place
  // of the daemon, start a shell that prints its session and its descriptors.
  const ScratchFolder scratch;
  int ends_of_pipe[2];
  ASSERT_EQ(::pipe(ends_of_pipe), 0);
  service_client::ServerProcess process(
      {"/bin/sh", "-c", "cut -d' ' -f6 /proc/$$/stat; echo $$; ls /proc/$$/fd | tr '\\n' ' '"},
      scratch / "state");
  ASSERT_TRUE(ends(process));
  ::close(ends_of_pipe[0]);
  ::close(ends_of_pipe[1]);
  const std::vector<std::string> lines = process.log_lines(3);
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_EQ(lines[0], lines[1]);
  EXPECT_EQ(lines[2], "0 1 2 ");
}

TEST(ServerProcess, SaysWhatIsMissing) {
  // Goal: the error about a missing daemon program names the program. A bad state folder is an
  // error too.
  try {
    static_cast<void>(service_client::program_beside("no-such-daemon"));
    FAIL() << "no error";
  } catch (const base::Error& error) {
    EXPECT_NE(std::string(error.what()).find("no-such-daemon"), std::string::npos);
  }
  EXPECT_THROW(service_client::ServerProcess({"/bin/true"}, "/dev/null/state"), base::Error);
}

TEST(ServerCommand, HandsSettingsOn) {
  EXPECT_EQ(
      server_command("/bin/sleightd", {{.key = "cores", .text = "8", .given_by = "--cores"},
                                       {.key = "memory", .text = "24 GB", .given_by = "--memory"}}),
      (std::vector<std::string>{"/bin/sleightd", "--cores=8", "--memory=24 GB"}));
}

}  // namespace
}  // namespace sleight::cli
