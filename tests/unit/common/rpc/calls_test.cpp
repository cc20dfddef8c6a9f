// Goal: calls travel over a socket from a client to the service, and answers travel back. Method:
// connect a client to a server with a made-up service.
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "common/rpc/client.h"
#include "tests/unit/common/rpc/fake_service.h"

namespace sleight::rpc {
namespace {

using testing::FakeService;
using testing::ServerThread;

class CallsTest : public testing::SocketFolder {
 protected:
  CallsTest() {
    for (std::uint64_t id = 1; id <= 3; ++id)
      service.jobs[id].view = {.id = {id}, .name = "job", .state = JobState::queued};
  }
  FakeService service;
};

template <class Call>
Refusal refusal_of(const Call& call) {
  try {
    call();
  } catch (const RefusedError& error) {
    return error.refusal();
  }
  ADD_FAILURE() << "was not refused";
  return {};
}

JobView full_view() {
  return {
      .id = {17},
      .group = GroupId{5},
      .user = 1000,
      .name = "höhe",
      .world = "ball_2d",
      .state = JobState::running,
      .reason = "others wait",
      .place = 3,
      .not_yet = "two cores are taken",
      .attempt = 2,
      .priority = -4,
      .cores_wanted = 8,
      .cores = 4,
      .ranks = 2,
      .memory_bytes = 1U << 30U,
      .strict = true,
      .pinned = true,
      .scans_done = 10,
      .scans_total = 40,
      .solutions = {.found = 1, .found_wanted = 2, .in_proportion = 3, .in_proportion_wanted = 4},
      .failures = {{"work_limit", 7}},
      .simulations_per_s = 12.5,
      .left_s = 0.0,
      .solutions_left_s = 9.5,
      .core_s = 100.25,
      .submitted_s = 1,
      .started_s = 2,
      .ended_s = 3,
      .bytes = 4096,
      .deleted_at_s = 5,
      .digest = "abc",
      .results_version = "r7",
      .end_words = "it gave up",
      .last_log_lines = {"a", "", "c"},
      .repeat_command = "sleight direct x.toml",
      .history = {testing::change_of(1), testing::change_of(2)}};
}

TEST_F(CallsTest, EachCallArrivesWithAllThatItSays) {
  // Goal: every field of every call and every answer arrives unchanged. Method: set each field to a
  // value that isn't its default. Compare the values on both ends.
  service.jobs[17].view = full_view();
  ServerThread server(socket(), service);
  Client client(socket());
  EXPECT_EQ(client.status({17}), full_view());

  const Submission submission = {.key = random_key(),
                                 .jobs = {{.name = "a",
                                           .request = std::string("text\0with zero", 14),
                                           .cores = 3,
                                           .ranks = 2,
                                           .memory_bytes = 77,
                                           .priority = -1,
                                           .strict = true},
                                          {.name = "b", .request = "other"}},
                                 .is_group = true};
  const Submitted submitted = client.submit(submission);
  EXPECT_EQ(service.submissions.back(), submission);
  EXPECT_EQ(service.last_user, ::getuid());
  EXPECT_EQ(submitted.jobs.size(), 2U);
  EXPECT_EQ(submitted.group, GroupId{5});
  EXPECT_FALSE(submitted.was_known);
  EXPECT_TRUE(client.submit(submission).was_known);

  const ListAsk ask = {.group = GroupId{5},
                       .user = 7,
                       .states = {JobState::held, JobState::cancelled},
                       .name_part = "x",
                       .oldest_first = true,
                       .count = 2,
                       .cursor = "1"};
  const JobPage page = client.list(ask);
  EXPECT_EQ(service.lists.back(), ask);
  EXPECT_EQ(page.jobs.size(), 2U);
  EXPECT_EQ(page.cursor, "3");
  EXPECT_EQ(page.total, 6U);
  JobView brief = full_view();
  brief.history.clear();
  brief.last_log_lines.clear();
  brief.repeat_command.clear();
  EXPECT_EQ(client.list({.cursor = "16"}).jobs.front(), brief);

  EXPECT_EQ(client.logs({.job = {1}, .lines = 2}).text, "two\nthree\n");
  const LogPiece piece = client.logs({.job = {1}, .from = 4, .bytes_max = 3});
  EXPECT_EQ(piece, (LogPiece{.first = 4, .text = "two", .end = 14, .is_over = true}));

  const Target one = Target::of(JobId{1});
  EXPECT_EQ(client.change({.target = one, .kind = ChangeKind::cancel}),
            (std::vector<Touched>{{.job = {1}, .state = JobState::running, .words = "cancel"}}));
  client.change({.target = one, .kind = ChangeKind::hold});
  const Target group = Target::of(GroupId{5});
  EXPECT_EQ(client.change({.target = group, .kind = ChangeKind::resume}).size(), 2U);
  client.change({.target = one,
                 .kind = ChangeKind::extend,
                 .extension = {.by = ExtendBy::odds, .to = 0.125}});
  client.change({.target = one, .kind = ChangeKind::erase});
  client.change({.target = one, .kind = ChangeKind::pin});
  client.change({.target = one, .kind = ChangeKind::unpin});
  client.change({.target = one, .kind = ChangeKind::set_priority, .priority = -3});
  client.drain();
  client.stop();
  EXPECT_EQ(service.calls, (std::vector<std::string>{
                               "cancel 1", "hold 1", "resume g5", "extend 4 0.125 1", "erase 1",
                               "pin 1", "unpin 1", "set_priority -3 1", "drain", "stop"}));

  const ServerView info = client.info();
  EXPECT_EQ(info.version, "1.2");
  EXPECT_EQ(info.limits, (std::vector<NamedLimit>{{.name = "cores", .value = "16 cores"}}));
  EXPECT_EQ(info.counts, (std::vector<StateCount>{{.state = JobState::queued, .count = 3}}));
  EXPECT_EQ(info.connections, 1U);
}

TEST_F(CallsTest, RefusalsSayWhatAndWhatToDo) {
  // Goal: every field of a refusal arrives. If a handler throws or drops its reply, the client gets
  // a refusal of kind `bug`, and only the server's log has the details.
  ServerThread server(socket(), service);
  Client client(socket());
  const Refusal bad = refusal_of(
      [&] { client.submit({.key = "k", .jobs = {{.name = "x.toml", .request = "bad"}}}); });
  EXPECT_EQ(
      bad,
      (Refusal{.kind = RefusalKind::bad_request,
               .sentence = "The request has errors.",
               .what_to_do = "Mend it.",
               .diagnostics = {{.file = "x.toml", .place = {12, 9}, .message = "unknown key"}}}));
  EXPECT_EQ(refusal_of([&] { client.status({99}); }).kind, RefusalKind::not_found);

  server.on_loop([&](Server&) { service.throws = true; });
  const Refusal bug = refusal_of([&] { client.status({1}); });
  EXPECT_EQ(bug.kind, RefusalKind::bug);
  EXPECT_EQ(bug.sentence.find("secret"), std::string::npos);
  EXPECT_EQ(server.complaints(), std::vector<std::string>{"a secret of the service"});

  server.on_loop([&](Server&) {
    service.throws = false;
    service.keeps_status = true;
  });
  std::thread forgets([&] {
    bool has_kept = false;
    EXPECT_TRUE(testing::comes_true([&] {
      server.on_loop([&](Server&) {
        has_kept = !service.kept.empty();
        service.kept.clear();
      });
      return has_kept;
    }));
  });
  EXPECT_EQ(refusal_of([&] { client.status({1}); }).kind, RefusalKind::bug);
  forgets.join();
}

TEST_F(CallsTest, AnswersMayComeLaterAndInAnyOrder) {
  // Goal: while a handler delays a reply, other clients are answered. If a client leaves before its
  // answer, it blocks no other client. Method: delay the answers to four clients. The first client
  // leaves early. Then answer in reverse order.
  service.keeps_status = true;
  ServerThread server(socket(), service);
  std::thread gives_up(
      [&] { EXPECT_THROW(Client(socket(), {.call_s_max = 1}).status({1}), base::Error); });
  gives_up.join();
  std::vector<std::thread> threads;
  for (std::uint64_t id = 1; id <= 3; ++id) {
    threads.emplace_back([&, id] {
      Client client(socket());
      EXPECT_EQ(client.status({id}).id.value, 100 * id);
    });
    EXPECT_TRUE(testing::comes_true([&] {
      std::size_t kept = 0;
      server.on_loop([&](Server&) { kept = service.kept.size(); });
      return kept == id + 1;
    }));
  }
  Client(socket()).info();
  server.on_loop([&](Server&) {
    for (std::uint64_t id = 3; id > 0; --id)
      service.kept[id].answer({.id = {100 * id}});
    service.kept[0].answer({});
    service.kept.clear();
  });
  for (std::thread& thread : threads)
    thread.join();
}

TEST_F(CallsTest, RequestsBeyondTheLimitsAreRefused) {
  // Goal: a call is refused if it exceeds a limit in service.h or contains an invalid value.
  ServerThread server(socket(), service);
  Client client(socket());
  const auto submit = [&](Submission submission) {
    return refusal_of([&] { client.submit(submission); }).kind;
  };
  const JobAsk job = {.name = "a", .request = "r"};
  EXPECT_EQ(submit({.key = "", .jobs = {job}}), RefusalKind::bad_request);
  EXPECT_EQ(submit({.key = std::string(65, 'k'), .jobs = {job}}), RefusalKind::bad_request);
  EXPECT_EQ(submit({.key = "k", .jobs = {}}), RefusalKind::bad_request);
  EXPECT_EQ(submit({.key = "k", .jobs = {{.name = "a\nb", .request = "r"}}}),
            RefusalKind::bad_request);
  EXPECT_EQ(submit({.key = "k", .jobs = std::vector<JobAsk>(1001, job)}), RefusalKind::limit);
  const JobAsk large = {.name = "a", .request = std::string((1U << 20U) + 1, 'r')};
  EXPECT_EQ(submit({.key = "k", .jobs = {large}}), RefusalKind::limit);
  const JobAsk half = {.name = "a", .request = std::string(1U << 19U, 'r')};
  EXPECT_EQ(submit({.key = "k", .jobs = std::vector<JobAsk>(7, half)}), RefusalKind::limit);
  EXPECT_TRUE(service.submissions.empty());
  EXPECT_EQ(client.submit({.key = "k", .jobs = std::vector<JobAsk>(6, half)}).jobs.size(), 6U);

  const Target none = Target::of(JobId{0});
  const auto refused = [&](const ChangeAsk& change) {
    return refusal_of([&] { client.change(change); }).kind;
  };
  EXPECT_EQ(refused({.target = none, .kind = ChangeKind::cancel}), RefusalKind::not_found);
  const Target one = Target::of(JobId{1});
  EXPECT_EQ(refused({.target = one}), RefusalKind::bad_request);
  for (const Extension& extension :
       {Extension{}, Extension{.by = ExtendBy::scans, .to = 1.5},
        Extension{.by = ExtendBy::scans, .to = 0}, Extension{.by = ExtendBy::odds, .to = -1}})
    EXPECT_EQ(refused({.target = one, .kind = ChangeKind::extend, .extension = extension}),
              RefusalKind::bad_request);
  EXPECT_TRUE(service.calls.empty());
  EXPECT_EQ(refusal_of([&] { client.list({.states = {JobState::unknown}}); }).kind,
            RefusalKind::bad_request);
  client.list({.count = 100'000});
  EXPECT_EQ(service.lists.back().count, k_page_jobs_max);
}

TEST_F(CallsTest, ViewsOfAnyLengthStayReadable) {
  // Goal: a client can read any answer, because the server cuts long texts and histories. The cut
  // never splits a character. Method: list 120 jobs whose texts have 70 kB. Read the status of a
  // job whose history is long.
  JobView huge = full_view();
  huge.reason = std::string(1, 'a') + [] {
    std::string text;
    for (int i = 0; i < 35'000; ++i)
      text += "ö";
    return text;
  }();
  huge.history.assign(5000, testing::change_of(3));
  huge.last_log_lines.assign(80, std::string(10'000, 'x'));
  for (std::uint64_t id = 1; id <= 120; ++id) {
    service.jobs[id].view = huge;
    service.jobs[id].view.id = {id};
  }
  ServerThread server(socket(), service);
  Client client(socket());
  const JobPage page = client.list({.count = 120});
  ASSERT_EQ(page.jobs.size(), 120U);
  EXPECT_EQ(page.jobs[7].reason.size(), 511U);  // 512 would cut a two-byte character
  const JobView view = client.status({3});
  EXPECT_EQ(view.history.size(), k_history_max);
  EXPECT_EQ(view.last_log_lines.size(), k_last_log_lines);
  EXPECT_EQ(view.reason.size(), k_text_bytes_max - 1);
}

TEST_F(CallsTest, TheSocketIsItsOwnersAloneAndOneServersAlone) {
  // Goal: only the owner of a socket can open it, and only one server listens on it. A server
  // replaces the socket of a dead server, and removes its own socket when it ends. Method: start
  // servers one after another and kill one. The socket's path is longer than the system allows for
  // sockets.
  const std::string deep = path(std::string(200, 'd'));
  std::filesystem::create_directory(deep);
  const std::string place = deep + "/socket";
  EXPECT_THROW(Client(place).info(), NoServer);
  EXPECT_THROW(Client(path("nowhere/socket")).info(), NoServer);
  {
    ServerThread server(place, service);
    struct stat seen = {};
    ASSERT_EQ(::stat(place.c_str(), &seen), 0);
    EXPECT_EQ(seen.st_mode & 0777U, 0600U);
    EXPECT_EQ(Client(place).info().version, "1.2");
    {
      Loop loop;
      FakeService other;
      try {
        Server second(loop, place, other);
        ADD_FAILURE() << "two servers listen";
      } catch (const base::Error& error) {
        EXPECT_EQ(error.exit_code(), base::ExitCode::conflict);
      }
    }
    EXPECT_EQ(Client(place).info().version, "1.2");
  }
  EXPECT_FALSE(std::filesystem::exists(place));
  const auto shared = testing::make_shared_memory();
  { testing::ServerProcess killed(place, *shared); }
  EXPECT_TRUE(std::filesystem::exists(place));
  EXPECT_THROW(Client(place).info(), NoServer);
  ServerThread server(place, service);
  EXPECT_EQ(Client(place).info().version, "1.2");
}

TEST_F(CallsTest, AClientOutlivesItsServers) {
  // Goal: if a client has lost its server, it connects to the next server on the same socket.
  Client client(socket());
  for (int i = 0; i < 3; ++i) {
    EXPECT_THROW(client.info(), NoServer);
    ServerThread server(socket(), service);
    EXPECT_EQ(client.info().version, "1.2");
  }
}

TEST_F(CallsTest, AClientMayPauseForLongerThanACallMayTake) {
  // Goal: between two calls, a client may pause for longer than one call may take. Method: make two
  // calls 2.5 s apart. Each call may take 2 s.
  ServerThread server(socket(), service);
  Client client(socket(), {.call_s_max = 2});
  EXPECT_EQ(client.info().version, "1.2");
  std::this_thread::sleep_for(std::chrono::milliseconds(2500));
  EXPECT_EQ(client.info().version, "1.2");
}

}  // namespace
}  // namespace sleight::rpc
