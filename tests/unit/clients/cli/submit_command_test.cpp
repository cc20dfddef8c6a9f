// Goal: a submission contains the request's text once for each combination of `--set` values. If
// the service refuses a request, the error looks like an error of `sleight check`. Method: call a
// real server with a scripted handler.
#include "clients/cli/submit_command.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "common/base/error.h"
#include "common/request/text.h"
#include "scripted_service.h"

namespace sleight::cli {
namespace {

/// Returns fake functions. The normalised text lists the function's inputs.
RequestTexts texts() {
  return {.normalised = [](std::string_view text, std::string_view file,
                           std::span<const request::KeySet> sets,
                           std::optional<request::Asked> asked)
              -> base::Result<std::string, std::vector<request::Diagnostic>> {
    if (text == "bad")
      return std::vector{request::Diagnostic{std::string(file), {3, 9}, "no such key"}};
    std::string normalised(text);
    for (const request::KeySet& set : sets)
      normalised += " " + set.text;
    if (asked) normalised += fmt::format(" n={}", asked->number);
    return normalised;
  }};
}

rpc::Submission made(const SubmitOptions& options, const GivenRequest& given) {
  auto submission = submission_of(options, given, texts());
  CHECK(submission.ok());
  return std::move(submission).value();
}

TEST(Submit, AnUnchangedRequestGoesAsItIsWritten) {
  // Goal: a submission contains the file's text unchanged, so the service's errors have the file's
  // line numbers. All options reach the service.
  const rpc::Submission submission =
      made({.request_path = "requests/hi.toml",
            .cores = 4,
            .ranks = 2,
            .memory = "2GB",
            .priority = -3,
            .strict = true},
           {.name = "requests/hi.toml", .text = "# mine\n[world]\n"});
  ASSERT_EQ(submission.jobs.size(), 1U);
  EXPECT_FALSE(submission.is_group);
  const rpc::JobAsk expected{.name = "hi",
                             .request = "# mine\n[world]\n",
                             .cores = 4,
                             .ranks = 2,
                             .memory_bytes = 2'000'000'000,
                             .priority = -3,
                             .strict = true};
  EXPECT_EQ(submission.jobs.front(), expected);
}

TEST(Submit, SetsAndNumberAreApplied) {
  // Goal: `--set` changes the text that is sent, and `-n` changes the text of a file.
  const rpc::Submission of_file = made({.request_path = "hi.toml",
                                        .asked = request::Asked{.number = 7},
                                        .asked_by = "-n 7",
                                        .sets = {"sampler.seed=3"}},
                                       {"hi.toml", "text"});
  EXPECT_EQ(of_file.jobs.front().request, "text sampler.seed=3 n=7");
  EXPECT_FALSE(of_file.is_group);
  const SubmitOptions word{.word = "HI", .asked = request::Asked{.number = 7}, .asked_by = "-n 7"};
  const GivenRequest given = given_request("", word.word, word.asked);
  EXPECT_EQ(given.name, "--word HI");
  EXPECT_EQ(made(word, given).jobs.front().request,
            "[world]\nname = \"spelling\"\nword = \"HI\"\n\n[stop]\ntakes = 7\n");
  EXPECT_EQ(made(word, given).jobs.front().name, "HI");
}

TEST(Submit, ARangeMakesAGroup) {
  // Goal: each value of a range gives one job, and the job's name contains the value. A range of
  // one value gives a group too. Method: submit a range of values for one key and a single value
  // for another key.
  const rpc::Submission group = made(
      {.request_path = "hi.toml", .sets = {"sampler.seed=1..3", "stop.scans=9"}, .name = "try"},
      {"hi.toml", "text"});
  EXPECT_TRUE(group.is_group);
  ASSERT_EQ(group.jobs.size(), 3U);
  EXPECT_EQ(group.jobs[1].name, "try sampler.seed=2");
  EXPECT_EQ(group.jobs[1].request, "text sampler.seed=2 stop.scans=9");
  EXPECT_TRUE(made({.request_path = "hi.toml", .sets = {"sampler.seed=1..1"}}, {"hi.toml", "text"})
                  .is_group);
}

TEST(Submit, ErrorsOfTheRequestHaveTheirPlaces) {
  // Goal: before anything is sent, a bad request gives the same errors as `sleight check`. The
  // place in each error includes the option -n.
  const auto bad = submission_of(
      {.request_path = "hi.toml", .asked = request::Asked{.number = 7}, .asked_by = "-n 7"},
      {"hi.toml", "bad"}, texts());
  ASSERT_FALSE(bad);
  EXPECT_EQ(request::to_string(bad.error().front()), "hi.toml with -n 7:3:9: no such key");
  EXPECT_FALSE(
      submission_of({.request_path = "hi.toml", .sets = {"nonsense"}}, {"hi.toml", "t"}, texts()));
}

TEST(Submit, WhatAnOptionGivesIsNotSetBeside) {
  // Goal: a `--set` that contradicts an option is refused. Method: combine --word and -n with
  // conflicting settings and with other settings.
  const auto is_taken = [](const SubmitOptions& options) {
    return submission_of(options, {"x", "text"}, texts()).ok();
  };
  EXPECT_FALSE(is_taken({.word = "HI", .sets = {"world.word=HO"}}));
  EXPECT_FALSE(is_taken({.word = "HI",
                         .asked = request::Asked{.number = 3},
                         .asked_by = "-n 3",
                         .sets = {"stop.independent_solutions=1..2"}}));
  EXPECT_FALSE(is_taken({.request_path = "x",
                         .asked = request::Asked{.number = 3},
                         .asked_by = "-n 3",
                         .sets = {"stop.scans=10"}}));
  EXPECT_TRUE(is_taken({.word = "HI", .sets = {"sampler.seed=2"}}));
  EXPECT_TRUE(is_taken({.request_path = "x", .sets = {"stop.scans=10"}}));
}

TEST(Submit, MoreThanASubmissionTakesIsRefused) {
  // Goal: too many jobs, too many bytes and invalid options are refused before any call to the
  // service.
  const auto throws = [](const SubmitOptions& options, const std::string& text) {
    EXPECT_THROW(static_cast<void>(submission_of(options, {"hi.toml", text}, texts())),
                 base::Error);
  };
  throws({.request_path = "hi.toml", .sets = {"sampler.seed=1..1001"}}, "text");
  throws({.request_path = "hi.toml", .sets = {"sampler.seed=1..4"}}, std::string(800'000, 'x'));
  throws({.request_path = "hi.toml", .memory = "much"}, "text");
  throws({.request_path = "hi.toml", .memory = "0"}, "text");
  EXPECT_THROW(given_request("", "", {}), base::Error);
  EXPECT_THROW(given_request("", "\xff", {}), base::Error);
  EXPECT_THROW(given_request("/no/such/file.toml", "", {}), base::Error);
}

TEST(Submit, NamesFitTheService) {
  // Goal: a job's default name is printable and within the service's limit, for any name of the
  // file. An explicit name that is too long is refused, never cut. Method: use a long name of
  // two-byte characters, first as a file name, then as an explicit name. Use a file name with an
  // escape character.
  std::string name;
  for (int i = 0; i < 200; ++i)
    name += "ü";
  const rpc::Submission submission =
      made({.request_path = name + ".toml", .sets = {"sampler.seed=1..2"}}, {"x", "text"});
  EXPECT_LE(submission.jobs.front().name.size(), rpc::k_name_bytes_max);
  EXPECT_TRUE(request::is_utf8(submission.jobs.front().name));
  const rpc::Submission unnamed = made({.request_path = "\x1b[2J.toml"}, {"x", "text"});
  EXPECT_EQ(unnamed.jobs.front().name, "\\u{1b}[2J");
  EXPECT_THROW((void)made({.request_path = "a.toml", .name = name}, {"x", "text"}), base::Error);
}

struct Printed {
  int code = 0;
  std::string out;
  std::string err;
};

Printed submit_to(const std::string& socket, const SubmitOptions& options) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Printed printed;
  printed.code = submit(socket, options, texts());
  printed.out = testing::internal::GetCapturedStdout();
  printed.err = testing::internal::GetCapturedStderr();
  return printed;
}

TEST(Submit, PrintsTheServicesErrorsAsCheckDoes) {
  // Goal: if the service refuses a request, the command exits with 3. Each line of the error names
  // the user's file, even if the service uses another name. Method: let the service return two
  // diagnostics. The second diagnostic contains control characters.
  const ScratchFolder scratch;
  const std::string file = scratch / "hi.toml";
  std::ofstream(file) << "text";
  ScriptedHandler handler;
  handler.on_submit = [](rpc::Submission, rpc::Reply<rpc::Submitted> reply) {
    reply.refuse({.kind = rpc::RefusalKind::bad_request,
                  .sentence = "The request has errors.",
                  .diagnostics = {{"request", {12, 9}, "unknown key 'lamda'"},
                                  {"request", {13, 1}, "\x1b[2J"}}});
  };
  const ServingThread serving(scratch / "socket", handler);
  const Printed printed = submit_to(scratch / "socket", {.request_path = file});
  EXPECT_EQ(printed.code, 3);
  EXPECT_EQ(printed.out, "");
  EXPECT_EQ(printed.err, file + ":12:9: unknown key 'lamda'\n" + file + ":13:1: \\u{1b}[2J\n");
}

/// A server process that dies when it gets its first submission. key() returns the submission's
/// key.
class DyingServer {
 public:
  explicit DyingServer(const std::string& socket) {
    int ends[2];
    CHECK(::pipe(ends) == 0);
    process_ = ::fork();
    CHECK(process_ >= 0);
    if (process_ == 0) serve(socket, ends[1]);
    ::close(ends[1]);
    said_ = ends[0];
    char listens = 0;
    CHECK(::read(said_, &listens, 1) == 1);
  }
  ~DyingServer() {
    ::close(said_);
    ::waitpid(process_, nullptr, 0);
  }
  DyingServer(const DyingServer&) = delete;
  DyingServer& operator=(const DyingServer&) = delete;

  std::string key() const {
    std::string key;
    char letter = 0;
    while (::read(said_, &letter, 1) == 1)
      key += letter;
    return key;
  }

 private:
  [[noreturn]] static void serve(const std::string& socket, int said) {
    ::alarm(k_life_s_max);
    ScriptedHandler silent;
    silent.on_submit = [said](const rpc::Submission& submission, const auto&) {
      CHECK(::write(said, submission.key.data(), submission.key.size()) > 0);
      ::raise(SIGKILL);
    };
    const ServingThread serving(socket, silent);
    CHECK(::write(said, "+", 1) == 1);
    for (;;)
      ::pause();
  }
  static constexpr unsigned k_life_s_max = 60;  // if nobody submits

  pid_t process_;
  int said_;
};

TEST(Submit, ALostAnswerSubmitsNothingTwice) {
  // Goal: if a server dies before it answers a submission, the client repeats the call with the
  // same key. Method: use a server that dies when it gets the submission. Then start a second
  // server at the same socket.
  const ScratchFolder scratch;
  const std::string socket = scratch / "socket";
  const DyingServer first(socket);
  std::string first_key;
  std::vector<std::string> later_keys;
  ScriptedHandler second;
  second.on_submit = [&](const rpc::Submission& submission, rpc::Reply<rpc::Submitted> reply) {
    later_keys.push_back(submission.key);
    reply.answer({.jobs = {rpc::JobId{17}}, .was_known = true});
  };
  std::unique_ptr<ServingThread> second_serving;
  std::jthread restart([&] {
    first_key = first.key();
    second_serving = std::make_unique<ServingThread>(socket, second);
  });
  const Printed printed = submit_to(socket, {.word = "HI", .json = true});
  restart.join();
  EXPECT_EQ(printed.code, 0);
  EXPECT_FALSE(first_key.empty());
  EXPECT_EQ(later_keys, std::vector<std::string>{first_key});
  EXPECT_NE(printed.out.find("\"id\": 17"), std::string::npos);
}

TEST(Submit, WithoutAServerSaysHowToStartOne) {
  // Goal: without a service, the exit code is 12 and the message names the command to start one.
  const ScratchFolder scratch;
  try {
    static_cast<void>(submit(scratch / "socket", {.word = "HI"}, texts()));
    FAIL() << "no error";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.exit_code(), base::ExitCode::no_server);
    EXPECT_NE(std::string(error.what()).find("`sleight server start`"), std::string::npos);
  }
}

}  // namespace
}  // namespace sleight::cli
