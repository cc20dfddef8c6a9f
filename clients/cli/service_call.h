// What the service's commands share: a client of the service of this machine, words and exit codes
// for what goes wrong, and Ctrl-C.
//
// Whatever came over the socket goes to the terminal through `shown`: the service may be another
// version, and jobs are named by other people.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <thread>

#include "common/base/error.h"
#include "common/rpc/client.h"

namespace sleight::cli {

/// Runs `work`, a command, with the service at `called`: a socket's path, or HOST:PORT of one that
/// was logged in to (known_servers.h). A refusal becomes a base::Error with its exit code and
/// words, no server ExitCode::no_server, whose words say how to start one.
int with_service(const std::string& called, const std::function<int(rpc::Client&)>& work);

/// not_allowed 9, bad_request 3, conflict 4, not_found and gone 2, bug 1; all else 5.
base::ExitCode exit_code_of(rpc::RefusalKind kind);

/// Its sentence and what to do, on one line.
std::string words_of(const rpc::Refusal& refusal);

/// Text of the service on one line, fit for a terminal.
std::string shown(std::string_view text);
/// Likewise, of text that may have several lines: they become one.
std::string shown_on_one_line(std::string text);

/// A line on stderr; where that is lost, the exit code still tells.
void complain(const std::string& line);

/// While it lives, this process ends as SIGPIPE would end it as soon as nobody reads its standard
/// output any more, also while it has nothing to write: `sleight watch 17 | head -1`.
class EndsWithItsReader {
 public:
  EndsWithItsReader();
  ~EndsWithItsReader();
  EndsWithItsReader(const EndsWithItsReader&) = delete;
  EndsWithItsReader& operator=(const EndsWithItsReader&) = delete;

 private:
  int over_;  ///< an eventfd; -1: there is none, and nothing is looked at
  std::thread look_;
};

/// While it lives, Ctrl-C and SIGTERM make this client's watch or fetch return instead of ending
/// the process; a second one ends it. One a process at a time; for the main thread.
class Interrupts {
 public:
  /// Without a client `requested` alone tells, and system calls that wait return.
  explicit Interrupts(rpc::Client* client);
  ~Interrupts();
  Interrupts(const Interrupts&) = delete;
  Interrupts& operator=(const Interrupts&) = delete;

  static bool requested();
};

}  // namespace sleight::cli
