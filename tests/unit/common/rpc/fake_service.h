// An in-memory service, and servers for it. A server runs in a thread of the test, or in a process
// that a test can kill.
//
// The fake service is a handler like the daemon's; the transport is real.
#pragma once

#include <gtest/gtest.h>
#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/rpc/handler.h"
#include "common/rpc/loop.h"
#include "common/rpc/server.h"

namespace sleight::rpc::testing {

/// A job that has events 1 to `events`. An event's content depends only on its number.
struct FakeJob {
  JobView view{};
  std::uint64_t events = 0;  ///< number of numbered events
  std::uint64_t changes = 1;
  std::uint64_t progress = 0;  ///< number of progress reports
  bool is_over = false;
};

events::RunEvent event_of(std::uint64_t number);
StateChange change_of(std::uint64_t number);
std::string content_of(std::size_t bytes, std::uint64_t seed);

class MemorySource final : public Source {
 public:
  MemorySource(std::string name, std::shared_ptr<const std::string> content, std::string sha256);
  FileView view() const override { return view_; }
  void read(std::uint64_t offset, std::size_t bytes, Reply<base::Bytes> reply) override;

 private:
  FileView view_;
  std::shared_ptr<const std::string> content_;
};

class FakeService final : public Handler {
 public:
  struct File {
    std::shared_ptr<const std::string> content;
    std::string sha256;  ///< the announced digest, which may be wrong
  };

  std::map<std::uint64_t, FakeJob> jobs{};
  std::map<std::string, Submitted> known_keys{};
  std::map<std::string, File> files{};
  std::vector<Submission> submissions{};
  std::vector<ListAsk> lists{};
  std::vector<FetchAsk> fetches{};
  std::vector<std::string> calls{};  ///< names and arguments of calls that change something
  std::vector<Reply<JobView>> kept{};
  std::uint64_t events_asked = 0;
  std::uint32_t last_user = 0;
  bool keeps_status = false;  ///< leaves status calls unanswered
  std::vector<Reply<Fetched>> kept_fetches{};
  bool keeps_fetches = false;  ///< leaves fetch calls unanswered
  bool throws = false;         ///< makes status throw
  std::uint64_t gap_at = 0;    ///< number of an event to leave out
  std::size_t files_in_page = k_fetch_files_max;
  std::function<void()> on_stop{};
  std::map<std::string, TokenView> tokens{};  ///< by id
  Caller last_caller{};                       ///< of the last status call

  void add_file(const std::string& name, std::string content);

  void submit(const Caller&, Submission, Reply<Submitted>) override;
  void list(const Caller&, ListAsk, Reply<JobPage>) override;
  void status(const Caller&, JobId, Reply<JobView>) override;
  base::Result<Batch, Refusal> events_after(const Caller&, const WatchPoint&,
                                            std::size_t events_max) override;
  void logs(const Caller&, LogAsk, Reply<LogPiece>) override;
  void change(const Caller&, ChangeAsk, Reply<std::vector<Touched>>) override;
  void fetch(const Caller&, FetchAsk, Reply<Fetched>) override;
  void info(const Caller&, Reply<ServerView>) override;
  void drain(const Caller&, Reply<Nothing>) override;
  void stop(const Caller&, Reply<Nothing>) override;
  void create_token(const Caller&, TokenAsk, Reply<TokenView>) override;
  void list_tokens(const Caller&, Reply<std::vector<TokenView>>) override;
  void revoke_token(const Caller&, std::string id, Reply<TokenView>) override;
};

class ServerThread {
 public:
  ServerThread(std::string path, FakeService& service, ServerLimits limits = {}, Audit audit = {});
  ~ServerThread();
  ServerThread(const ServerThread&) = delete;
  ServerThread& operator=(const ServerThread&) = delete;

  void on_loop(const std::function<void(Server&)>& work);
  ServerCounts counts();
  std::vector<std::string> complaints();

 private:
  Loop* loop_ = nullptr;
  Server* server_ = nullptr;
  std::mutex mutex_;
  std::vector<std::string> complaints_;
  std::thread thread_;
};

/// State that a server's process and the test share.
struct Shared {
  std::atomic<std::uint64_t> events = 0;    ///< of job 1
  std::atomic<std::uint64_t> progress = 0;  ///< likewise
  std::atomic<bool> is_over = false;
  int nursery = -1;  ///< socket to the process that forks servers
};

/// A server in its own process. The server has job 1 and a file "ball.h5" of `file_bytes`. A
/// nursery process, which never has a second thread, forks the server (see make_shared_memory()).
/// If another thread held a sanitizer's lock during the fork, the new process would wait for the
/// lock forever.
class ServerProcess {
 public:
  ServerProcess(const std::string& path, Shared& shared, std::size_t file_bytes = 1000,
                ServerLimits limits = {});
  ~ServerProcess();  ///< kills the process
  ServerProcess(const ServerProcess&) = delete;
  ServerProcess& operator=(const ServerProcess&) = delete;

  pid_t pid() const { return pid_; }
  void kill();
  std::size_t peak_bytes() const;

 private:
  const Shared& shared_;
  pid_t pid_;
};

/// Creates a `Shared` object in memory that processes share. REQUIRES: the test has no other thread
/// yet.
std::shared_ptr<Shared> make_shared_memory();

class SocketFolder : public ::testing::Test {
 protected:
  SocketFolder();
  ~SocketFolder() override;
  std::string path(const std::string& name) const { return folder_ + "/" + name; }
  std::string socket() const { return path("socket"); }

 private:
  std::string folder_;
};

/// Checks how much a server's memory has grown since `before`. Sanitizers hold freed memory for a
/// while, so sanitizer builds check nothing.
void expect_grown_less(const ServerProcess& server, std::size_t before, std::size_t bytes_max);

/// Waits some seconds for the condition.
bool comes_true(const std::function<bool()>& condition);

}  // namespace sleight::rpc::testing
