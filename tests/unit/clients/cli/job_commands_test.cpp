// Goal: commands that name jobs make the right calls, print the answers and exit with the right
// code. Method: call a real server with a scripted handler on a real socket.
#include "clients/cli/job_commands.h"

#include <gtest/gtest.h>

#include <csignal>
#include <string>
#include <vector>

#include "clients/cli/fetch_command.h"
#include "clients/cli/logs_command.h"
#include "clients/cli/server_commands.h"
#include "clients/cli/service_json.h"
#include "common/base/error.h"
#include "common/base/file_system.h"
#include "common/json/value.h"
#include "scripted_service.h"
#include "tests/support/facts.h"

namespace sleight::cli {
namespace {

/// A service with four jobs: 17 is done, 18 is running, 19 has failed, and 20 was cancelled. Jobs
/// 17 and 18 are in group g5.
class JobCommands : public testing::Test {
 protected:
  JobCommands() {
    handler_.jobs = {job(17, rpc::JobState::done, rpc::GroupId{5}),
                     job(18, rpc::JobState::running, rpc::GroupId{5}),
                     job(19, rpc::JobState::failed), job(20, rpc::JobState::cancelled)};
    handler_.on_events = [&](const rpc::WatchPoint& point) { return batch_of(point); };
  }

  static rpc::JobView job(std::uint64_t id, rpc::JobState state,
                          std::optional<rpc::GroupId> group = {}) {
    return {.id = {id},
            .group = group,
            .name = fmt::format("job{}", id),
            .world = "spelling",
            .state = state,
            .solutions = {.found = 2, .in_proportion = 1},
            .bytes = 1'500'000};
  }

  /// Returns a change of state and two numbered events. If the job has ended, the batch is settled.
  base::Result<rpc::Batch, rpc::Refusal> batch_of(const rpc::WatchPoint& point) {
    const auto job = std::ranges::find(handler_.jobs, point.job, &rpc::JobView::id);
    if (job == handler_.jobs.end()) return no_such_job(point.job);
    rpc::Batch batch{.mark = 1, .settled = rpc::is_settled(job->state)};
    if (point.change < 1)
      batch.changes = {{.number = 1, .state = job->state, .reason = "scripted"}};
    for (std::uint64_t number = point.event + 1; number <= 2; ++number)
      batch.events.push_back({number, events::Solution{.nth = number}});
    return batch;
  }

  const std::string& serve() {
    serving_ = std::make_unique<ServingThread>(socket_, handler_);
    return socket_;
  }

  /// Returns a command's output and stores its exit code in code_.
  std::string out(const std::function<int()>& command) {
    testing::internal::CaptureStdout();
    try {
      code_ = command();
    } catch (const base::Error& error) {
      code_ = static_cast<int>(error.exit_code());
      words_ = error.what();
    }
    return testing::internal::GetCapturedStdout();
  }

  ScratchFolder scratch_;
  std::string socket_ = scratch_ / "socket";
  ScriptedHandler handler_;
  std::unique_ptr<ServingThread> serving_;
  int code_ = -1;
  std::string words_;
};

WatchOptions watched(std::vector<std::string> jobs, bool json = false, std::uint64_t from = 1) {
  WatchOptions options;
  options.jobs = std::move(jobs);
  options.json = json;
  options.from_number = from;
  return options;
}

const rpc::ChangeAsk k_cancel{.kind = rpc::ChangeKind::cancel};

TEST_F(JobCommands, ListShowsPagesAndFilters) {
  // Goal: the list command sends filters to the service and joins pages. If the list is limited, it
  // ends with the command for the next page. Method: use a service that returns a cursor and two
  // jobs per page.
  std::vector<rpc::ListAsk> asks;
  const std::vector<rpc::JobView> jobs = handler_.jobs;
  handler_.on_list = [&](rpc::ListAsk ask, rpc::Reply<rpc::JobPage> reply) {
    asks.push_back(ask);
    const std::size_t first = ask.cursor.empty() ? 0 : 2;
    reply.answer(
        {.jobs = {jobs[first], jobs[first + 1]}, .cursor = first == 0 ? "second" : "", .total = 4});
  };
  serve();
  const std::string all = out([&] {
    return list_jobs(socket_, {.states = {"done", "failed"},
                               .user = std::to_string(::getuid()),
                               .group = "g5",
                               .name = "job",
                               .oldest_first = true});
  });
  EXPECT_EQ(code_, 0);
  for (const char* id : {"17", "18", "19", "20"})
    EXPECT_NE(all.find(id), std::string::npos) << all;
  ASSERT_EQ(asks.size(), 2U);
  EXPECT_EQ(asks[0].states, (std::vector{rpc::JobState::done, rpc::JobState::failed}));
  EXPECT_EQ(asks[0].user, ::getuid());
  EXPECT_EQ(asks[0].group, rpc::GroupId{5});
  EXPECT_EQ(asks[0].name_part, "job");
  EXPECT_TRUE(asks[0].oldest_first);
  EXPECT_EQ(asks[1].cursor, "second");
  const std::string page = out([&] { return list_jobs(socket_, {.count = 2}); });
  EXPECT_THAT(page, tests::HasFacts("2 of 4|--all|--after 'second'"));
  const Json json =
      Json::parse(out([&] { return list_jobs(socket_, {.count = 2, .json = true}); }));
  EXPECT_EQ(json["jobs"].size(), 2U);
  EXPECT_EQ(json["total"], 4);
  EXPECT_EQ(json["after"], "second");
}

TEST_F(JobCommands, ListRefusesFiltersThatAreNone) {
  // Goal: if a filter is invalid, the command exits with 2 before it calls the service. Method: run
  // the command without a service.
  for (const ListOptions& options :
       {ListOptions{.states = {"finished"}}, ListOptions{.user = "no such user"},
        ListOptions{.mine = true, .user = "root"}, ListOptions{.group = "17"}}) {
    out([&] { return list_jobs(socket_, options); });
    EXPECT_EQ(code_, 2);
  }
}

TEST_F(JobCommands, CompletionIsSilentWithoutAServer) {
  // Goal: shell completion prints the ids of jobs with descriptions, or nothing without a server.
  EXPECT_EQ(out([&] { return list_jobs(socket_, {.complete = true}); }), "");
  EXPECT_EQ(code_, 0);
  serve();
  const std::string lines = out([&] { return list_jobs(socket_, {.complete = true}); });
  EXPECT_EQ(lines.substr(0, lines.find('\n')), "17\tjob17, done");
}

TEST_F(JobCommands, RefusalsHaveTheirExitCodes) {
  // Goal: the exit code states the kind of a refusal, and the error message states the remedy.
  const std::vector<std::pair<rpc::RefusalKind, int>> kinds{
      {rpc::RefusalKind::not_found, 2},   {rpc::RefusalKind::gone, 2},
      {rpc::RefusalKind::not_allowed, 9}, {rpc::RefusalKind::bad_request, 3},
      {rpc::RefusalKind::conflict, 4},    {rpc::RefusalKind::limit, 5},
      {rpc::RefusalKind::environment, 5}, {rpc::RefusalKind::bug, 1}};
  std::size_t nth = 0;
  handler_.on_change = [&](const rpc::ChangeAsk&, rpc::Reply<std::vector<rpc::Touched>> reply) {
    reply.refuse({.kind = kinds[nth].first, .sentence = "No\x1b.", .what_to_do = "Do this."});
  };
  serve();
  for (nth = 0; nth < kinds.size(); ++nth) {
    out([&] { return change(socket_, {.jobs = {"17"}}, k_cancel); });
    EXPECT_EQ(code_, kinds[nth].second);
    EXPECT_EQ(words_, "No\\u{1b}. Do this.");
  }
}

TEST_F(JobCommands, NamesReachTheServiceAsTargets) {
  // Goal: a command makes one call for a whole group, but one call for each job of a range. A range
  // skips missing jobs.
  std::vector<rpc::Target> targets;
  handler_.on_change = [&](const rpc::ChangeAsk& ask, rpc::Reply<std::vector<rpc::Touched>> reply) {
    const rpc::Target& target = ask.target;
    targets.push_back(target);
    EXPECT_EQ(ask.kind, rpc::ChangeKind::cancel);
    if (target.job && target.job->value > 20) return reply.refuse(no_such_job(*target.job));
    reply.answer({{.job = {17}, .state = rpc::JobState::cancelled, .words = "stops"}});
  };
  serve();
  const std::string text = out([&] {
    return change(socket_, {.jobs = {"g5", "20..22"}}, k_cancel);
  });
  EXPECT_EQ(code_, 0);
  EXPECT_EQ(text, "17 cancelled: stops\n17 cancelled: stops\n");
  EXPECT_EQ(targets,
            (std::vector{rpc::Target::of(rpc::GroupId{5}), rpc::Target::of(rpc::JobId{20}),
                         rpc::Target::of(rpc::JobId{21}), rpc::Target::of(rpc::JobId{22})}));
  // The command reports a refused job and continues with the other jobs.
  EXPECT_EQ(out([&] {
              return change(socket_, {.jobs = {"21", "17", "22"}}, k_cancel);
            }),
            "17 cancelled: stops\n");
  EXPECT_EQ(code_, 2);
  out([&] { return change(socket_, {.jobs = {"21..25"}}, k_cancel); });
  EXPECT_EQ(code_, 2);
  const Json json = Json::parse(out([&] { return change(socket_, {{"17"}, true}, k_cancel); }));
  EXPECT_EQ(json["state"], "cancelled");
}

TEST_F(JobCommands, StatusOfAGroupIsAList) {
  serve();
  StatusOptions options;
  options.jobs = {"g5"};
  options.json = true;
  Json json = Json::parse(out([&] { return show_status(socket_, options); }));
  ASSERT_EQ(json.size(), 2U);
  EXPECT_EQ(json[1]["state"], "running");
  options.jobs = {"17"};
  json = Json::parse(out([&] { return show_status(socket_, options); }));
  EXPECT_EQ(json["found"], 2);
  EXPECT_EQ(json["in_proportion"], 1);
  options.jobs = {"99"};
  out([&] { return show_status(socket_, options); });
  EXPECT_EQ(code_, 2);
}

TEST_F(JobCommands, WatchAndWaitEndAsTheJobsDid) {
  // Goal: the exit code is 0 for a done job, 10 for a failed job, 11 for a cancelled job, and the
  // worst code for several jobs. If a job doesn't exist, the code is 2.
  serve();
  const auto code_of = [&](const std::vector<std::string>& jobs) {
    out([&] { return watch(socket_, watched(jobs)); });
    const int watch_code = code_;
    out([&] { return wait(socket_, {.jobs = jobs}); });
    EXPECT_EQ(code_, watch_code);
    return code_;
  };
  EXPECT_EQ(code_of({"17"}), 0);
  EXPECT_EQ(code_of({"19"}), 10);
  EXPECT_EQ(code_of({"20"}), 11);
  EXPECT_EQ(code_of({"17", "20", "19"}), 10);
  EXPECT_EQ(code_of({"17", "20"}), 11);
  EXPECT_EQ(code_of({"99"}), 2);
}

TEST_F(JobCommands, WaitPrintsTheEndAlone) {
  serve();
  EXPECT_EQ(out([&] { return wait(socket_, {.jobs = {"17"}}); }),
            "17 job17 done: 2 found, 1 in proportion\n");
  const Json json = Json::parse(out([&] { return wait(socket_, {{"17"}, true}); }));
  EXPECT_EQ(json["state"], "done");
}

TEST_F(JobCommands, WatchTellsEachEventOnALine) {
  // Goal: a watch prints one line for each change of state and one line for the end. The watch also
  // prints a line for each event from a given event on. Method: watch a job that has two events.
  // Start at the second event and print JSON.
  serve();
  const std::string text = out([&] { return watch(socket_, watched({"17"}, true, 2)); });
  std::vector<Json> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);)
    lines.push_back(Json::parse(line));
  ASSERT_EQ(lines.size(), 3U) << text;
  EXPECT_EQ(lines[0]["kind"], "state");
  EXPECT_EQ(lines[0]["state"], "done");
  EXPECT_EQ(lines[1]["kind"], "solution");
  EXPECT_EQ(lines[1]["number"], 2);
  EXPECT_EQ(lines[1]["job"], 17);
  EXPECT_EQ(lines[2]["kind"], "settled");
  EXPECT_EQ(lines[2]["state"], "done");
  EXPECT_EQ(out([&] { return watch(socket_, watched({"17"})); }),
            "done: scripted\nfound 1: start 0, log p 0\nfound 2: start 0, log p 0\n"
            "17 job17 done: 2 found, 1 in proportion\n");
}

TEST_F(JobCommands, CtrlCLeavesTheJob) {
  // Goal: an interrupted watch exits with 130, prints how to resume watching, and cancels nothing.
  // Method: send SIGINT while the command watches a running job that has no news.
  serve();
  handler_.on_events = [&](const rpc::WatchPoint& point) {
    if (point.change > 0) {
      ::kill(::getpid(), SIGINT);
      return base::Result<rpc::Batch, rpc::Refusal>(rpc::Batch{});
    }
    return base::Result<rpc::Batch, rpc::Refusal>(
        rpc::Batch{.changes = {{.number = 1, .state = rpc::JobState::running}}});
  };
  testing::internal::CaptureStderr();
  out([&] { return watch(socket_, watched({"18"})); });
  const std::string words = testing::internal::GetCapturedStderr();
  EXPECT_EQ(code_, 130);
  EXPECT_NE(words.find("`sleight watch 18`"), std::string::npos) << words;
}

TEST_F(JobCommands, DeleteTakesNothingOfWhatRuns) {
  // Goal: if one of several jobs is running or pinned, none is deleted. Method: try to delete a
  // group that has a running job. Then try to delete a pinned job together with another job. Then
  // delete ended jobs.
  std::vector<rpc::Target> erased;
  handler_.on_change = [&](const rpc::ChangeAsk& ask, rpc::Reply<std::vector<rpc::Touched>> reply) {
    EXPECT_EQ(ask.kind, rpc::ChangeKind::erase);
    erased.push_back(ask.target);
    reply.answer({{.job = *ask.target.job, .state = rpc::JobState::done}});
  };
  serve();
  DeleteOptions options;
  options.jobs = {"g5"};
  out([&] { return delete_jobs(socket_, options); });
  EXPECT_EQ(code_, 4);
  EXPECT_TRUE(erased.empty());
  handler_.jobs[2].pinned = true;
  options.jobs = {"17", "19"};
  out([&] { return delete_jobs(socket_, options); });
  EXPECT_EQ(code_, 4);
  EXPECT_TRUE(erased.empty());
  handler_.jobs[2].pinned = false;
  EXPECT_EQ(out([&] { return delete_jobs(socket_, options); }),
            "deleted 17 (job17, done, 1.5 MB)\ndeleted 19 (job19, failed, 1.5 MB)\n");
  EXPECT_EQ(erased.size(), 2U);
}

TEST_F(JobCommands, ChangesReachTheServiceWithTheirWords) {
  // Goal: all fields of a change reach the service. The command prints its own text for priorities
  // and pins, and the service's text for other changes.
  std::vector<rpc::ChangeAsk> asks;
  handler_.on_change = [&](const rpc::ChangeAsk& ask, rpc::Reply<std::vector<rpc::Touched>> reply) {
    asks.push_back(ask);
    reply.answer({{.job = {17}, .state = rpc::JobState::queued, .words = "soon"}});
  };
  serve();
  const auto said = [&](const rpc::ChangeAsk& ask) {
    const std::string text = out([&] { return change(socket_, {.jobs = {"17"}}, ask); });
    rpc::ChangeAsk expected = ask;
    expected.target = rpc::Target::of(rpc::JobId{17});
    EXPECT_EQ(asks.back(), expected);
    return text;
  };
  EXPECT_EQ(said({.kind = rpc::ChangeKind::set_priority, .priority = -3}),
            "17 queued: priority -3\n");
  EXPECT_EQ(said({.kind = rpc::ChangeKind::pin}), "17 queued: pinned\n");
  EXPECT_EQ(said({.kind = rpc::ChangeKind::unpin}), "17 queued: not pinned\n");
  EXPECT_EQ(said({.kind = rpc::ChangeKind::extend,
                  .extension = {.by = rpc::ExtendBy::scans, .to = 1e12}}),
            "17 queued: soon\n");
}

TEST(ExtendOptions, TakeOneRule) {
  // Goal: the options of an extension must contain exactly one stop rule.
  ExtendOptions options;
  EXPECT_THROW(extension_of(options), base::Error);
  options.scans = 1'000'000'000'000;
  EXPECT_EQ(extension_of(options), (rpc::Extension{rpc::ExtendBy::scans, 1e12}));
  options.odds = 0.1;
  EXPECT_THROW(extension_of(options), base::Error);
}

TEST_F(JobCommands, LogsFollowsToTheEnd) {
  // Goal: the bytes of a log are printed once, in whole lines, until the log's end. Method: follow
  // a growing log that contains an escape sequence. The service sends pieces of the log that end
  // inside a line and inside a character.
  const std::string log = "first\nse\x1b[2Jcond ü\nlast without an end";
  std::size_t written = 8;
  handler_.on_logs = [&](rpc::LogAsk ask, rpc::Reply<rpc::LogPiece> reply) {
    const std::size_t from = ask.from.value_or(0);
    const std::string text = log.substr(from, written - from);
    const bool is_over = written == log.size();
    reply.answer({.first = from, .text = text, .end = written, .is_over = is_over});
    written = std::min(log.size(), written + 13);
  };
  serve();
  EXPECT_EQ(out([&] { return show_logs(socket_, {.job = "17", .follow = true}); }),
            "first\nse\\u{1b}[2Jcond ü\nlast without an end\n");
  EXPECT_EQ(code_, 0);
  out([&] { return show_logs(socket_, {.job = "g5"}); });
  EXPECT_EQ(code_, 2);
}

TEST(LogLines, ComeWholeHoweverTheyAreCut) {
  // Goal: the output doesn't depend on how a log is cut into pieces. A line without an end is
  // split. Method: print a text byte by byte, then whole. Print a long line.
  const std::string text = "a\tb\r\nü\xff\n\nrest";
  LogLines at_once;
  LogLines bytewise;
  std::string lines;
  for (const char c : text)
    lines += bytewise.add(std::string_view(&c, 1));
  lines += bytewise.rest();
  std::string whole = at_once.add(text);
  whole += at_once.rest();
  EXPECT_EQ(lines, whole);
  EXPECT_EQ(lines, "a    b\nü\\xff\n\nrest\n");
  LogLines endless;
  std::string parts;
  for (int i = 0; i < 300; ++i)
    parts += endless.add(std::string(1000, 'x'));
  EXPECT_EQ(std::ranges::count(parts, '\n'), 4);
}

class Fetching : public JobCommands {
 protected:
  Fetching() {
    handler_.on_fetch = [&](rpc::FetchAsk ask, rpc::Reply<rpc::Fetched> reply) {
      asks_.push_back(ask);
      if (ask.job == rpc::JobId{18}) {
        return reply.refuse(
            {.kind = rpc::RefusalKind::not_found, .sentence = "Job 18 has no archive yet."});
      }
      rpc::Fetched fetched;
      fetched.files.push_back(std::make_unique<TextSource>("out.h5", archive_));
      reply.answer(std::move(fetched));
    };
    serve();
  }
  int fetch_to(const std::string& path, bool force = false) {
    out([&] { return fetch(socket_, {.jobs = {"17"}, .output = path, .force = force}, check_); });
    return code_;
  }

  std::string archive_ = std::string(3'000'000, 'a');
  std::vector<rpc::FetchAsk> asks_;
  std::vector<std::string> checked_;  ///< contents of the checked archives
  bool is_damaged_ = false;
  ArchiveCheck check_ = [this](const std::string& path, const rpc::JobView& job) {
    EXPECT_EQ(job.id.value, 17U);
    checked_.push_back(base::read_text_file(path, 10'000'000));
    if (is_damaged_) throw base::Error(base::ExitCode::bad_archive, "it is damaged");
  };
};

TEST_F(Fetching, BringsTheFileWhole) {
  // Goal: a fetch creates the file and nothing else in the folder.
  const std::string path = scratch_ / "hi.h5";
  EXPECT_EQ(fetch_to(path), 0);
  EXPECT_EQ(base::read_text_file(path, 10'000'000), archive_);
  EXPECT_EQ(base::PosixFileSystem().names_in(base::directory_of(path)),
            (std::vector<std::string>{"hi.h5", "socket"}));
}

TEST_F(Fetching, LeavesOtherFilesAlone) {
  // Goal: without --force, a fetch doesn't replace a file whose content differs, and leaves no
  // partial file.
  const std::string path = scratch_ / "hi.h5";
  base::PosixFileSystem files;
  base::write_text_file(files, path, "mine");
  EXPECT_EQ(fetch_to(path), 4);
  EXPECT_NE(words_.find("--force"), std::string::npos) << words_;
  EXPECT_EQ(base::read_text_file(path, 10'000'000), "mine");
  EXPECT_EQ(fetch_to(path, true), 0);
  EXPECT_EQ(base::read_text_file(path, 10'000'000), archive_);
  EXPECT_EQ(fetch_to(path), 0);
  EXPECT_EQ(files.names_in(base::directory_of(path)),
            (std::vector<std::string>{"hi.h5", "socket"}));
}

TEST_F(Fetching, DamagedArchivesTakeNoPlace) {
  // Goal: a fetch checks an archive before it puts the archive in place. A damaged archive leaves
  // no partial file and doesn't replace the old file.
  const std::string path = scratch_ / "hi.h5";
  base::PosixFileSystem files;
  base::write_text_file(files, path, "mine");
  is_damaged_ = true;
  EXPECT_EQ(fetch_to(path, true), 6);
  EXPECT_NE(words_.find("it is damaged"), std::string::npos) << words_;
  EXPECT_EQ(checked_, std::vector<std::string>{archive_});
  EXPECT_EQ(base::read_text_file(path, 10'000'000), "mine");
  EXPECT_EQ(files.names_in(base::directory_of(path)),
            (std::vector<std::string>{"hi.h5", "socket"}));
  is_damaged_ = false;
  EXPECT_EQ(fetch_to(path, true), 0);
  EXPECT_EQ(base::read_text_file(path, 10'000'000), archive_);
}

TEST_F(Fetching, AGroupFillsAFolder) {
  // Goal: each archive of a group gets its own file name. A job without an archive is reported, and
  // the other jobs' archives are still fetched.
  const std::string folder = scratch_ / "deep/g5";
  testing::internal::CaptureStderr();
  const Json json = Json::parse(out(
      [&] { return fetch(socket_, {.jobs = {"g5"}, .output = folder, .json = true}, check_); }));
  const std::string words = testing::internal::GetCapturedStderr();
  EXPECT_EQ(code_, 2);
  EXPECT_NE(words.find("job 18: Job 18 has no archive yet."), std::string::npos) << words;
  ASSERT_EQ(json.size(), 1U);
  EXPECT_EQ(json[0]["files"][0], folder + "/job-17.h5");
  EXPECT_EQ(base::read_text_file(folder + "/job-17.h5", 10'000'000), archive_);
}

TEST_F(Fetching, FailuresGoIntoAFolder) {
  const std::string folder = scratch_ / "failures";
  out([&] { return fetch(socket_, {.jobs = {"17"}, .output = folder, .failures = true}, check_); });
  EXPECT_EQ(code_, 0);
  EXPECT_EQ(asks_.front().kind, rpc::FetchKind::failure_files);
  EXPECT_EQ(base::read_text_file(folder + "/out.h5", 10'000'000), archive_);
}

TEST(FetchAsk, IdsAreNumbersAndRanges) {
  // Goal: a list of ids is refused if it is invalid or longer than the service's limit.
  EXPECT_EQ(recording_ids_of("7,3,5..6,3"), (std::vector<std::uint64_t>{3, 5, 6, 7}));
  EXPECT_EQ(recording_ids_of("0"), (std::vector<std::uint64_t>{0}));
  EXPECT_EQ(recording_ids_of("18446744073709551615..18446744073709551615")->size(), 1U);
  for (const char* text :
       {"", ",", "1,", "a", "3..", "..3", "5..3", "1..10001", "1..6000,6001..12000"})
    EXPECT_FALSE(recording_ids_of(text)) << text;
  EXPECT_THROW(fetch_ask_of({.so_far = true, .failures = true}), base::Error);
  EXPECT_EQ(fetch_ask_of({.so_far = true}).kind, rpc::FetchKind::so_far);
}

TEST(FetchAsk, PlacesAreNamedByJobs) {
  const rpc::JobId job{17};
  EXPECT_EQ(place_of({}, job, false, {}), "job-17.h5");
  EXPECT_EQ(place_of({.output = "hi.h5"}, job, false, {}), "hi.h5");
  EXPECT_EQ(place_of({}, job, true, rpc::GroupId{5}), "g5/job-17.h5");
  EXPECT_EQ(place_of({}, job, true, {}), "./job-17.h5");
  EXPECT_EQ(place_of({.output = "all"}, job, true, rpc::GroupId{5}), "all/job-17.h5");
  EXPECT_EQ(place_of({.failures = true}, job, false, {}), "job-17-failures");
  EXPECT_EQ(place_of({.recordings = "3"}, job, false, {}), "job-17-recordings");
}

TEST_F(JobCommands, ServerCommandsTellOfTheServer) {
  // Goal: the JSON output of `status` contains the server's process id. Without a server, `status`
  // exits with 12, and `stop` succeeds.
  out([&] { return show_server(socket_, false); });
  EXPECT_EQ(code_, 12);
  out([&] { return stop_server(socket_, false); });
  EXPECT_EQ(code_, 0);
  handler_.server.counts = {{rpc::JobState::queued, 3}, {rpc::JobState::done, 0}};
  serve();
  const Json json = Json::parse(out([&] { return show_server(socket_, true); }));
  EXPECT_EQ(json["pid"], ::getpid());
  EXPECT_EQ(json["socket"], socket_);
  EXPECT_EQ(json["draining"], false);
  const std::string text = out([&] { return show_server(socket_, false); });
  EXPECT_NE(text.find("jobs        3 queued\n"), std::string::npos) << text;
  out([&] { return drain_server(socket_, false); });
  EXPECT_NE(out([&] { return show_server(socket_, false); }).find("draining"), std::string::npos);
}

}  // namespace
}  // namespace sleight::cli
