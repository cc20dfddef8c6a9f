// Goal: a batch system's answers and a job's folder determine the inputs of the jobs' state
// machine. If the system doesn't answer, this never ends an attempt. Method: use a backend that
// returns the test's answers. The test writes the keeper's records.
#include "service/daemon/system_attempts.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "common/base/clock.h"
#include "common/base/file_system.h"
#include "common/store/lease_files.h"

namespace sleight::daemon {
namespace {

using backend::Cause;
using backend::State;
using ::testing::HasSubstr;

constexpr jobs::JobId k_job{17};
constexpr jobs::Attempt k_attempt{3};
/// Timeout of a failing test.
constexpr double k_patience_s = 20;
/// If an input is going to arrive, it arrives within this number of list() calls.
constexpr std::uint64_t k_lists = 20;

/// A backend that returns the test's answers.
class HandBackend final : public backend::Backend {
 public:
  using Answer = std::function<backend::Seen()>;

  backend::Seen launch(const backend::Order& order) override {
    const std::scoped_lock lock(mutex_);
    orders_.push_back(order);
    return answer_();
  }
  backend::Seen state(const backend::AttemptName&) override {
    const std::scoped_lock lock(mutex_);
    return answer_();
  }
  bool signal(const backend::AttemptName&, keeper::Stop how) override {
    const std::scoped_lock lock(mutex_);
    signals_.push_back(how);
    return true;
  }
  std::map<backend::AttemptName, backend::Seen> list(const std::string& daemon) override {
    const std::scoped_lock lock(mutex_);
    ++lists_;
    const backend::Seen seen = answer_();
    if (seen.state == State::absent) return {};
    return {{{.daemon = daemon, .job = k_job.value, .epoch = k_attempt.value}, seen}};
  }
  std::string log(const backend::AttemptName&, const std::string&, std::size_t) override {
    return "slurmstepd: it burnt";
  }
  std::string title() const override { return "Slurm"; }

  void says(Answer answer) {
    const std::scoped_lock lock(mutex_);
    answer_ = std::move(answer);
  }
  void says(const backend::Seen& seen) {
    says([seen] { return seen; });
  }
  std::uint64_t lists() {
    const std::scoped_lock lock(mutex_);
    return lists_;
  }
  std::vector<backend::Order> orders() {
    const std::scoped_lock lock(mutex_);
    return orders_;
  }
  std::vector<keeper::Stop> signals() {
    const std::scoped_lock lock(mutex_);
    return signals_;
  }

 private:
  std::mutex mutex_;
  Answer answer_ = [] { return backend::Seen{}; };
  std::uint64_t lists_ = 0;
  std::vector<backend::Order> orders_;
  std::vector<keeper::Stop> signals_;
};

class SystemAttemptsTest : public ::testing::Test {
 protected:
  explicit SystemAttemptsTest(double settle_s = 0.02)
      : state_([] {
          std::string pattern = "/tmp/sleight-system-XXXXXX";
          return std::string(::mkdtemp(pattern.data()));
        }()),
        folders_(state_),
        feeds_(folders_, clock_, [](jobs::JobId) {}),
        attempts_({.loop = loop_,
                   .clock = clock_,
                   .files = files_,
                   .folders = folders_,
                   .feeds = feeds_,
                   .backend = backend_,
                   .daemon_id = "abcdefgh",
                   .list_every_s = 0.02,
                   .look_every_s = 0.02,
                   .settle_s = settle_s,
                   .programs = {.keeper = "/opt/sleight-keeper",
                                .sleight = "/opt/sleight",
                                .sleight_batch = "/opt/sleight-batch"},
                   .text_of =
                       [](auto, auto) {
                         return LaunchText{.request = "# none\n", .options = {{"qos", "high"}}};
                       },
                   .hear =
                       [this](jobs::Input input) {
                         if (!std::holds_alternative<jobs::BackendNote>(input))
                           heard_.push_back(std::move(input));
                       }}) {
    files_.make_folder(folders_.all());
  }
  ~SystemAttemptsTest() override { std::filesystem::remove_all(state_); }

  void launch(std::uint32_t ranks = 0) {
    attempts_.launch({.job = k_job,
                      .attempt = k_attempt,
                      .cores = 2,
                      .ranks = ranks,
                      .memory_bytes = 1'000'000'000});
  }
  void look() {
    files_.make_folder(folders_.folder(k_job));
    attempts_.look({.job = k_job, .attempt = k_attempt});
  }
  void spin(double seconds) {
    const auto timer = loop_.call_later(seconds, [&] { loop_.stop(); });
    loop_.run();
  }
  void until(const std::function<bool()>& holds) {
    const double end_s = clock_.now_s() + k_patience_s;
    while (!holds() && clock_.now_s() < end_s)
      spin(0.01);
    EXPECT_TRUE(holds()) << "waited in vain; " << heard_.size() << " were heard";
  }
  void await_lists() {
    const std::uint64_t before = backend_->lists();
    until([&] { return backend_->lists() >= before + k_lists; });
  }
  /// Waits for a sight of this kind. Returns the newest sight of this kind.
  template <class Kind>
  Kind sight() {
    until([&] { return newest<Kind>() != nullptr; });
    const Kind* kind = newest<Kind>();
    return kind == nullptr ? Kind{} : *kind;
  }
  /// Like sight(), but calls look() repeatedly: an answer that is on its way may have the old
  /// state.
  template <class Kind>
  Kind sight_of_looks() {
    until([&] {
      attempts_.look({.job = k_job, .attempt = k_attempt});
      return newest<Kind>() != nullptr;
    });
    return sight<Kind>();
  }
  template <class Kind>
  const Kind* newest() const {
    for (auto input = heard_.rbegin(); input != heard_.rend(); ++input) {
      const auto* sight = std::get_if<jobs::Sight>(&*input);
      if (sight == nullptr) continue;
      EXPECT_EQ(sight->job, k_job);
      EXPECT_EQ(sight->attempt, k_attempt);
      if (const auto* kind = std::get_if<Kind>(&sight->seen)) return kind;
    }
    return nullptr;
  }
  template <class Kind>
  bool has_heard() const {
    return std::ranges::any_of(
        heard_, [](const auto& input) { return std::holds_alternative<Kind>(input); });
  }
  bool has_heard_an_end() const {
    return newest<jobs::Ended>() != nullptr || newest<jobs::Died>() != nullptr ||
           has_heard<jobs::LaunchFailed>();
  }

  keeper::AttemptRecord record() const {
    return {.attempt = static_cast<std::uint32_t>(k_attempt.value),
            .keeper = {.pid = 1, .start_ticks = 1, .boot = "elsewhere"},
            .command = {"/opt/sleight", "direct"}};
  }
  void write(const keeper::AttemptRecord& record) {
    base::write_text_file(files_, folders_.folder(k_job) + "/attempt.json.new", to_text(record));
    files_.rename(folders_.folder(k_job) + "/attempt.json.new",
                  folders_.folder(k_job) + "/attempt.json");
  }
  void begins() { write(record()); }
  void ends(events::End how) {
    keeper::AttemptRecord ended = record();
    ended.end = keeper::AttemptEnd{.exit_code = 0, .run_end = events::RunEnd{.end = how}};
    write(ended);
  }
  void waits() { backend_->says({.state = State::waiting, .id = "812", .words = "Priority"}); }
  void runs() { backend_->says({.state = State::running, .id = "812"}); }
  void is_gone(const std::string& words, Cause cause) {
    backend_->says({.state = State::gone, .id = "812", .words = words, .cause = cause});
  }
  /// Launches the attempt and waits until its run is active.
  void launch_and_begin() {
    waits();
    launch();
    sight<jobs::Pending>();
    runs();
    begins();
    until([&] { return has_heard<jobs::Launched>(); });
  }

  std::string state_;
  base::SteadyClock clock_;
  base::PosixFileSystem files_;
  JobFolders folders_;
  Feeds feeds_;
  rpc::Loop loop_;
  std::shared_ptr<HandBackend> backend_ = std::make_shared<HandBackend>();
  std::vector<jobs::Input> heard_;
  SystemAttempts attempts_;
};

TEST_F(SystemAttemptsTest, WaitRunAndEnd) {
  waits();
  launch();
  EXPECT_EQ(sight<jobs::Pending>().words, "Slurm job 812 is waiting: Priority");
  await_lists();
  EXPECT_EQ(heard_.size(), 1U) << "the same words once";
  ASSERT_EQ(backend_->orders().size(), 1U);
  const backend::Order order = backend_->orders().front();
  EXPECT_EQ(to_text(order.name), "sleight:abcdefgh:17:3");
  EXPECT_EQ(order.folder, folders_.folder(k_job));
  EXPECT_EQ(order.memory_bytes, 1'000'000'000U);
  EXPECT_EQ(order.options.at("qos"), "high");
  EXPECT_THAT(order.command, ::testing::Contains("--batch"));
  EXPECT_TRUE(files_.exists(folders_.request(k_job)));

  runs();
  until([&] { return newest<jobs::Pending>()->words.find("has started") != std::string::npos; });
  begins();
  until([&] { return has_heard<jobs::Launched>(); });
  attempts_.look({.job = k_job, .attempt = k_attempt});
  sight<jobs::Running>();
  ends(events::End::finished);
  EXPECT_EQ(sight<jobs::Ended>().kind, jobs::EndKind::finished) << "whatever the system says yet";
  EXPECT_EQ(attempts_.running(), 0U);
}

TEST_F(SystemAttemptsTest, RanksAskForTheMemoryOfAll) {
  waits();
  launch(8);
  sight<jobs::Pending>();
  const backend::Order order = backend_->orders().front();
  EXPECT_EQ(order.ranks, 8U);
  EXPECT_EQ(order.memory_bytes, 8'000'000'000U);
  EXPECT_THAT(order.command, ::testing::IsSupersetOf({"--ranks", "mpirun", "/opt/sleight-batch"}));
}

TEST_F(SystemAttemptsTest, ThatSomebodyElseStoppedEndOnceItIsKnownWho) {
  launch_and_begin();
  ends(events::End::stop_requested);
  await_lists();
  EXPECT_FALSE(has_heard_an_end());
  is_gone("CANCELLED", Cause::cancelled);
  const auto ended = sight<jobs::Ended>();
  EXPECT_EQ(ended.outside, jobs::Outside::cancelled);
  EXPECT_EQ(ended.outside_words, "Slurm job 812: CANCELLED");
}

TEST_F(SystemAttemptsTest, ThatWeStoppedEndAtOnce) {
  launch_and_begin();
  attempts_.stop({.job = k_job, .attempt = k_attempt});
  until([&] { return !backend_->signals().empty(); });
  EXPECT_EQ(backend_->signals().front(), keeper::Stop::in_order);
  ends(events::End::stop_requested);
  EXPECT_EQ(sight<jobs::Ended>().outside, jobs::Outside::nothing);
}

TEST_F(SystemAttemptsTest, ThatLeaveNoEndHaveDied) {
  launch_and_begin();
  is_gone("NODE_FAIL", Cause::taken);
  const auto died = sight<jobs::Died>();
  EXPECT_EQ(died.words, "Slurm job 812: NODE_FAIL.");
  EXPECT_EQ(died.outside, jobs::Outside::taken);
}

/// Waits for late files on a shared disk so long that delays of a busy machine don't matter.
class SystemAttemptsOnASlowDisk : public SystemAttemptsTest {
 protected:
  SystemAttemptsOnASlowDisk() : SystemAttemptsTest(k_patience_s) {}
};

TEST_F(SystemAttemptsOnASlowDisk, WhoseEndIsSeenLateHaveNotDied) {
  // Goal: if an attempt's end appears late on a shared disk, the attempt doesn't count as died.
  // Method: let the backend report that the job is gone. Then write the end within the allowed
  // time.
  launch_and_begin();
  is_gone("COMPLETED", Cause::itself);
  await_lists();
  ends(events::End::finished);
  sight<jobs::Ended>();
  EXPECT_EQ(newest<jobs::Died>(), nullptr);
}

TEST_F(SystemAttemptsTest, WhoseRunMayLiveOnALostNodeAreWaitedFor) {
  // Goal: while another machine renews the run's lease, an attempt on a failed node doesn't count
  // as died. Method: renew a lease of 1.5 s during two seconds. Then stop.
  launch_and_begin();
  const std::string run = folders_.run(k_job);
  files_.make_folder(run);
  store::LeaseText lease{
      .holder = {.host = "lost", .machine = "lost", .process = 1}, .token = "t", .lease_s = 1.5};
  store::PosixLeaseFiles leases(run, lease.holder);
  const auto own = leases.make(1, lease.to_text());
  ASSERT_TRUE(own);
  is_gone("NODE_FAIL", Cause::taken);
  for (int i = 0; i < 20; ++i) {
    ++lease.beat;
    own->write(lease.to_text());
    spin(0.1);
  }
  EXPECT_FALSE(has_heard_an_end());
  sight<jobs::Died>();
}

TEST_F(SystemAttemptsTest, ThatNeverHadARecordSayWhatTheSystemSays) {
  is_gone("FAILED (NonZeroExitCode)", Cause::itself);
  launch();
  const auto died = sight<jobs::Died>();
  EXPECT_EQ(died.words, "Slurm job 812: FAILED (NonZeroExitCode).");
  EXPECT_EQ(died.log_end, "slurmstepd: it burnt");
}

TEST_F(SystemAttemptsTest, ThatTheSystemHasForgottenAreJudgedByTheirFolder) {
  // Method: call look(), as a new daemon does. The folder first has a record with an end, then a
  // record without an end, and at last no record.
  look();
  begins();
  ends(events::End::stop_requested);
  EXPECT_EQ(sight<jobs::Ended>().outside, jobs::Outside::nothing);
  heard_.clear();
  begins();
  look();
  EXPECT_THAT(sight<jobs::Died>().words, HasSubstr("no longer lists"));
  heard_.clear();
  std::filesystem::remove(folders_.folder(k_job) + "/attempt.json");
  look();
  sight<jobs::NeverBegan>();
  heard_.clear();
  await_lists();
  EXPECT_TRUE(heard_.empty()) << "that it isn't there is told to looks alone";
}

TEST_F(SystemAttemptsTest, OfASystemThatIsAwayAreUnknown) {
  launch_and_begin();
  backend_->says([]() -> backend::Seen { throw backend::Away("no controller"); });
  EXPECT_THAT(sight_of_looks<jobs::Unknown>().words, HasSubstr("no controller"));
  await_lists();
  EXPECT_FALSE(has_heard_an_end());
  EXPECT_EQ(attempts_.running(), 1U);
  heard_.clear();
  runs();
  sight_of_looks<jobs::Running>();
}

TEST_F(SystemAttemptsTest, ThatAnAwaySystemMayHaveAreLookedForAndOthersAreNot) {
  backend_->says([]() -> backend::Seen { throw backend::Away("lost", true); });
  launch();
  sight<jobs::Unknown>();
  EXPECT_FALSE(has_heard<jobs::LaunchFailed>());
  backend_->says([]() -> backend::Seen { throw backend::Away("away", false); });
  launch();
  until([&] { return has_heard<jobs::LaunchFailed>(); });
  const auto* failed = std::get_if<jobs::LaunchFailed>(&heard_.back());
  ASSERT_NE(failed, nullptr);
  EXPECT_TRUE(failed->is_backend_away);
}

TEST_F(SystemAttemptsTest, ThatTheSystemRefusesFailWithItsWords) {
  backend_->says([]() -> backend::Seen { throw base::Error("Invalid account"); });
  launch();
  until([&] { return has_heard<jobs::LaunchFailed>(); });
  const auto* failed = std::get_if<jobs::LaunchFailed>(&heard_.back());
  ASSERT_NE(failed, nullptr);
  EXPECT_FALSE(failed->is_backend_away);
  EXPECT_EQ(failed->words, "Invalid account");
}

TEST_F(SystemAttemptsTest, WhoseFolderIsDeletedAreEnded) {
  launch_and_begin();
  std::filesystem::remove_all(folders_.folder(k_job));
  EXPECT_THAT(sight<jobs::Died>().words, HasSubstr("folder was deleted"));
  until([&] { return !backend_->signals().empty(); });
  EXPECT_EQ(backend_->signals().front(), keeper::Stop::now);
}

}  // namespace
}  // namespace sleight::daemon
