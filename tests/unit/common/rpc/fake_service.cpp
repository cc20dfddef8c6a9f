#include "tests/unit/common/rpc/fake_service.h"

#include <fmt/format.h>
#include <limits.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <type_traits>

#include "common/access/token_text.h"
#include "common/base/check.h"
#include "common/hash/sha256.h"
#include "common/rpc/client.h"

namespace sleight::rpc::testing {
namespace {

Refusal not_found() {
  return {
      .kind = RefusalKind::not_found, .sentence = "There is no such job.", .what_to_do = "List."};
}

std::string word(Target target) {
  return target.job ? fmt::format("{}", target.job->value)
                    : fmt::format("g{}", target.group->value);
}

}  // namespace

events::RunEvent event_of(std::uint64_t number) {
  return {.number = number,
          .what = events::Solution{.nth = number, .in_proportion = true, .scan = 10 * number}};
}

StateChange change_of(std::uint64_t number) {
  return {.number = number,
          .time_s = 100.0 + static_cast<double>(number),
          .state = number == 1 ? JobState::queued : JobState::running,
          .reason = fmt::format("reason {}", number),
          .attempt = number - 1};
}

std::string content_of(std::size_t bytes, std::uint64_t seed) {
  std::string content(bytes, '\0');
  std::uint64_t state = seed * 0x9E3779B97F4A7C15U + 1;
  for (char& c : content) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    c = static_cast<char>(state >> 56U);
  }
  return content;
}

MemorySource::MemorySource(std::string name, std::shared_ptr<const std::string> content,
                           std::string sha256)
    : view_{.name = std::move(name), .size = content->size(), .sha256 = std::move(sha256)},
      content_(std::move(content)) {}

void MemorySource::read(std::uint64_t offset, std::size_t bytes, Reply<base::Bytes> reply) {
  CHECK_LE(offset + bytes, content_->size());
  const auto* first = reinterpret_cast<const std::byte*>(content_->data()) + offset;
  reply.answer(base::Bytes(first, first + bytes));
}

void FakeService::add_file(const std::string& name, std::string content) {
  std::string sha256 = hash::sha256_hex(content);
  files[name] = {std::make_shared<const std::string>(std::move(content)), std::move(sha256)};
}

void FakeService::submit(const Caller& caller, Submission submission, Reply<Submitted> reply) {
  last_user = caller.user;
  submissions.push_back(submission);
  const auto known = known_keys.find(submission.key);
  if (known != known_keys.end()) {
    Submitted again = known->second;
    again.was_known = true;
    reply.answer(again);
    return;
  }
  Submitted submitted;
  for (const JobAsk& ask : submission.jobs) {
    if (ask.request == "bad") {
      reply.refuse(
          {.kind = RefusalKind::bad_request,
           .sentence = "The request has errors.",
           .what_to_do = "Mend it.",
           .diagnostics = {{.file = ask.name, .place = {12, 9}, .message = "unknown key"}}});
      return;
    }
    const std::uint64_t id = jobs.size() + 1;
    jobs[id].view = {.id = {id}, .name = ask.name, .state = JobState::queued};
    submitted.jobs.push_back({id});
  }
  if (submission.is_group) submitted.group = GroupId{5};
  known_keys[submission.key] = submitted;
  reply.answer(submitted);
}

void FakeService::list(const Caller&, ListAsk ask, Reply<JobPage> reply) {
  lists.push_back(ask);
  JobPage page = {.jobs = {}, .cursor = {}, .total = jobs.size()};
  const std::uint64_t after = ask.cursor.empty() ? 0 : std::stoull(ask.cursor);
  for (auto job = jobs.upper_bound(after); job != jobs.end(); ++job) {
    if (page.jobs.size() == ask.count) {
      page.cursor = fmt::format("{}", page.jobs.back().id.value);
      break;
    }
    page.jobs.push_back(job->second.view);
  }
  reply.answer(std::move(page));
}

void FakeService::status(const Caller& caller, JobId id, Reply<JobView> reply) {
  last_caller = caller;
  if (throws) throw std::runtime_error("a secret of the service");
  if (keeps_status) {
    kept.push_back(std::move(reply));
    return;
  }
  const auto job = jobs.find(id.value);
  if (job == jobs.end()) {
    reply.refuse(not_found());
  } else {
    reply.answer(job->second.view);
  }
}

base::Result<Batch, Refusal> FakeService::events_after(const Caller&, const WatchPoint& point,
                                                       std::size_t events_max) {
  ++events_asked;
  const auto found = jobs.find(point.job.value);
  if (found == jobs.end()) return not_found();
  const FakeJob& job = found->second;
  Batch batch;
  for (std::uint64_t number = point.change + 1; number <= job.changes; ++number)
    batch.changes.push_back(change_of(number));
  std::uint64_t number = point.event;
  while (number < job.events && batch.events.size() < events_max) {
    if (++number != gap_at) batch.events.push_back(event_of(number));
  }
  batch.mark = job.progress + 1;
  if (point.mark != batch.mark) {
    batch.events.push_back(
        {.number = 0, .what = events::Progress{.scans_done = job.progress, .scans_total = 1000}});
  }
  batch.settled = job.is_over && number == job.events;
  return batch;
}

void FakeService::logs(const Caller&, LogAsk ask, Reply<LogPiece> reply) {
  const std::string log = "one\ntwo\nthree\n";
  if (!ask.from) {
    reply.answer({.first = 4, .text = log.substr(4), .end = log.size(), .is_over = true});
    return;
  }
  const std::uint64_t first = std::min<std::uint64_t>(*ask.from, log.size());
  reply.answer({.first = first,
                .text = log.substr(first, ask.bytes_max),
                .end = log.size(),
                .is_over = true});
}

void FakeService::change(const Caller&, ChangeAsk ask, Reply<std::vector<Touched>> reply) {
  std::string call(name_of(ask.kind));
  if (ask.kind == ChangeKind::extend)
    call += fmt::format(" {} {}", static_cast<int>(ask.extension.by), ask.extension.to);
  if (ask.kind == ChangeKind::set_priority) call += fmt::format(" {}", ask.priority);
  calls.push_back(call + " " + word(ask.target));
  if (ask.target.group) {
    reply.answer({{.job = {1}, .state = JobState::held, .words = "a"},
                  {.job = {2}, .state = JobState::done, .words = "b"}});
  } else if (jobs.count(ask.target.job->value) == 0) {
    reply.refuse(not_found());
  } else {
    reply.answer({{.job = *ask.target.job, .state = JobState::running, .words = call}});
  }
}

void FakeService::fetch(const Caller&, FetchAsk ask, Reply<Fetched> reply) {
  fetches.push_back(ask);
  if (keeps_fetches) {
    kept_fetches.push_back(std::move(reply));
    return;
  }
  if (jobs.count(ask.job.value) == 0) {
    reply.refuse(not_found());
    return;
  }
  Fetched fetched;
  for (auto file = files.upper_bound(ask.after); file != files.end(); ++file) {
    if (fetched.files.size() == files_in_page) {
      fetched.has_more = true;
      break;
    }
    fetched.files.push_back(
        std::make_unique<MemorySource>(file->first, file->second.content, file->second.sha256));
  }
  reply.answer(std::move(fetched));
}

void FakeService::info(const Caller&, Reply<ServerView> reply) {
  reply.answer({.version = "1.2",
                .results_version = "r7",
                .state_folder = "/state",
                .pid = ::getpid(),
                .up_s = 12.5,
                .limits = {{.name = "cores", .value = "16 cores"}},
                .counts = {{.state = JobState::queued, .count = 3}}});
}

void FakeService::drain(const Caller&, Reply<Nothing> reply) {
  calls.emplace_back("drain");
  reply.answer({});
}

void FakeService::stop(const Caller&, Reply<Nothing> reply) {
  calls.emplace_back("stop");
  reply.answer({});
  if (on_stop) on_stop();
}

void FakeService::create_token(const Caller& caller, TokenAsk ask, Reply<TokenView> reply) {
  const std::string id = access::token_of(ask.token)->id;
  tokens[id] = {.id = id,
                .name = ask.name,
                .user = ask.for_user.value_or(caller.user),
                .scopes = ask.scopes,
                .created_s = 1000,
                .expires_s = ask.valid_s,
                .jobs_max = ask.jobs_max,
                .cores_max = ask.cores_max};
  reply.answer(tokens[id]);
}

void FakeService::list_tokens(const Caller&, Reply<std::vector<TokenView>> reply) {
  std::vector<TokenView> all;
  for (const auto& [id, token] : tokens)
    all.push_back(token);
  reply.answer(std::move(all));
}

void FakeService::revoke_token(const Caller&, std::string id, Reply<TokenView> reply) {
  const auto token = tokens.find(id);
  if (token == tokens.end()) {
    reply.refuse(not_found());
    return;
  }
  token->second.revoked_s = 2000;
  reply.answer(token->second);
}

ServerThread::ServerThread(std::string path, FakeService& service, ServerLimits limits,
                           Audit audit) {
  std::mutex mutex;
  std::condition_variable started;
  bool is_started = false;
  thread_ = std::thread([&, path, limits, audit] {
    Loop loop;
    Server server(loop, path, service,
                  {.limits = limits,
                   .complain =
                       [this](const std::string& words) {
                         const std::lock_guard lock(mutex_);
                         complaints_.push_back(words);
                       },
                   .audit = audit});
    {
      const std::lock_guard lock(mutex);
      loop_ = &loop;
      server_ = &server;
      is_started = true;
      started.notify_one();
    }
    loop.run();
  });
  std::unique_lock lock(mutex);
  started.wait(lock, [&] { return is_started; });
}

ServerThread::~ServerThread() {
  loop_->stop();
  thread_.join();
}

void ServerThread::on_loop(const std::function<void(Server&)>& work) {
  std::mutex mutex;
  std::condition_variable done;
  bool is_done = false;
  loop_->post([&] {
    work(*server_);
    const std::lock_guard lock(mutex);
    is_done = true;
    done.notify_one();
  });
  std::unique_lock lock(mutex);
  done.wait(lock, [&] { return is_done; });
}

ServerCounts ServerThread::counts() {
  ServerCounts counts;
  on_loop([&](Server& server) { counts = server.counts(); });
  return counts;
}

std::vector<std::string> ServerThread::complaints() {
  const std::lock_guard lock(mutex_);
  return complaints_;
}

namespace {

void serve(const std::string& path, Shared& shared, std::size_t file_bytes,
           const ServerLimits& limits) {
  FakeService service;
  service.jobs[1].view = {.id = {1}, .name = "one", .state = JobState::running};
  service.add_file("ball.h5", content_of(file_bytes, 1));
  Loop loop;
  Server server(loop, path, service, {.limits = limits});
  const auto look = loop.call_every(0.0005, [&] {
    FakeJob& job = service.jobs[1];
    const bool is_over = shared.is_over;  // read before the events that it announces
    const std::uint64_t events = shared.events;
    if (job.events == events && job.progress == shared.progress && job.is_over == is_over) return;
    job.events = events;
    job.progress = shared.progress;
    job.is_over = is_over;
    server.news({1});
  });
  loop.run();
}

struct Ask {
  pid_t kill = 0;            ///< 0: start a server
  char path[PATH_MAX] = {};  ///< of any length; servers shorten it for the system
  std::size_t file_bytes = 0;
  ServerLimits limits{};
};
static_assert(std::is_trivially_copyable_v<Ask>);

pid_t start(const Ask& ask, Shared& shared) {
  const pid_t pid = ::fork();
  if (pid != 0) return pid;
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  ::close_range(3, ~0U, 0);
  // A client may have left an event loop in the test's thread, so serve in a new thread.
  std::thread([&] { serve(ask.path, shared, ask.file_bytes, ask.limits); }).join();
  ::_exit(0);
}

/// Starts and ends servers until the test closes its socket. Servers don't inherit open files.
[[noreturn]] void run_nursery(int socket, Shared& shared) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  ::dup2(socket, 3);
  ::close_range(4, ~0U, 0);
  Ask ask;
  while (::recv(3, &ask, sizeof ask, 0) == sizeof ask) {
    pid_t answer = ask.kill;
    if (ask.kill == 0) {
      answer = start(ask, shared);
    } else {
      ::kill(ask.kill, SIGKILL);
      ::waitpid(ask.kill, nullptr, 0);
    }
    if (::send(3, &answer, sizeof answer, MSG_NOSIGNAL) != sizeof answer) break;
  }
  ::_exit(0);
}

/// REQUIRES: no other thread calls this function at the same time.
pid_t asked(const Shared& shared, const Ask& ask) {
  pid_t answer = -1;
  CHECK(::send(shared.nursery, &ask, sizeof ask, MSG_NOSIGNAL) == sizeof ask);
  CHECK(::recv(shared.nursery, &answer, sizeof answer, 0) == sizeof answer);
  return answer;
}

}  // namespace

ServerProcess::ServerProcess(const std::string& path, Shared& shared, std::size_t file_bytes,
                             ServerLimits limits)
    : shared_(shared) {
  Ask ask = {.kill = 0, .file_bytes = file_bytes, .limits = limits};
  CHECK_LT(path.size(), sizeof ask.path);
  path.copy(ask.path, path.size());
  pid_ = asked(shared_, ask);
  EXPECT_TRUE(comes_true([&] {
    try {
      Client(path, {.call_s_max = 5}).info();
      return true;
    } catch (const base::Error&) {  // not ready yet
      return false;
    }
  }));
}

ServerProcess::~ServerProcess() {
  kill();
}

void ServerProcess::kill() {
  if (pid_ <= 0) return;
  asked(shared_, {.kill = pid_});
  pid_ = -1;
}

std::size_t ServerProcess::peak_bytes() const {
  std::ifstream status(fmt::format("/proc/{}/status", pid_));
  std::string line;
  while (std::getline(status, line)) {
    if (line.rfind("VmHWM:", 0) == 0) return std::stoull(line.substr(6)) << 10U;
  }
  return 0;
}

void expect_grown_less([[maybe_unused]] const ServerProcess& server,
                       [[maybe_unused]] std::size_t before,
                       [[maybe_unused]] std::size_t bytes_max) {
#ifndef SLEIGHT_SANITIZED
  EXPECT_GT(before, std::size_t{0});
  EXPECT_LT(server.peak_bytes() - before, bytes_max);
#endif
}

std::shared_ptr<Shared> make_shared_memory() {
  void* memory =
      ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  CHECK(memory != MAP_FAILED);
  auto* shared = new (memory) Shared;
  int ends[2] = {};
  CHECK(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) == 0);
  const pid_t pid = ::fork();
  if (pid == 0) run_nursery(ends[1], *shared);
  ::close(ends[1]);
  shared->nursery = ends[0];
  return {shared, [pid](Shared* last) {
            ::close(last->nursery);
            ::waitpid(pid, nullptr, 0);
            ::munmap(last, sizeof(Shared));
          }};
}

SocketFolder::SocketFolder() {
  std::string form = (std::filesystem::temp_directory_path() / "sleight-rpc-XXXXXX").string();
  folder_ = ::mkdtemp(form.data());
}

SocketFolder::~SocketFolder() {
  std::filesystem::remove_all(folder_);
}

bool comes_true(const std::function<bool()>& condition) {
  for (int i = 0; i < 4000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

}  // namespace sleight::rpc::testing
