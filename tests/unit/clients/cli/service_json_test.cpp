// Goal: JSON about the service has the documented fields and types. Method: make views with values
// of all kinds, convert them to JSON, and compare the fields with the expected values.
#include "clients/cli/service_json.h"

#include "clients/cli/server_commands.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace sleight::cli {
namespace {

TEST(ServiceJson, SubmittedHasTheIdThatCommandsTake) {
  // Goal: the field `id` of a submission's JSON is accepted by every other command. The field is a
  // number for a job, and a text for a group.
  EXPECT_EQ(on_one_line(to_json(rpc::Submitted{.jobs = {rpc::JobId{17}}})),
            R"({"id":17,"group":null,"ids":[17]})");
  EXPECT_EQ(on_one_line(to_json(rpc::Submitted{.jobs = {rpc::JobId{17}, rpc::JobId{18}},
                                               .group = rpc::GroupId{5}})),
            R"({"id":"g5","group":"g5","ids":[17,18]})");
}

TEST(ServiceJson, AJobTellsWhatIsNotKnownAsNull) {
  // Goal: if a time or a queue place is missing, its value is null, not zero. Each count has its
  // own key.
  const Json json = to_json(
      rpc::JobView{.id = {17},
                   .state = rpc::JobState::queued,
                   .solutions = {.found = 2, .in_proportion = 1, .in_proportion_wanted = 50},
                   .failures = {{"work_limit", 3}, {"search_gave_up", 1}},
                   .submitted_s = 12.5},
      true);
  EXPECT_EQ(json["id"], 17);
  EXPECT_EQ(json["state"], "queued");
  EXPECT_EQ(json["submitted"], 12.5);
  for (const char* key : {"group", "place", "started", "ended", "left_seconds", "cores_wanted",
                          "scans_total", "deleted_at"})
    EXPECT_TRUE(json.at(key).is_null()) << key;
  EXPECT_EQ(json["found"], 2);
  EXPECT_EQ(json["in_proportion"], 1);
  EXPECT_EQ(json["failed_simulations"].dump(), R"({"total":4,"work_limit":3,"search_gave_up":1})");
  EXPECT_TRUE(json["history"].is_array());
}

TEST(ServiceJson, OneJobAloneIsAnObject) {
  // Goal: a query for one job prints an object, so that `status 17 --json | jq .state` works. Other
  // queries print a list.
  const std::vector<rpc::JobView> jobs{{.id = {17}}};
  EXPECT_TRUE(jobs_json(jobs, true).is_object());
  EXPECT_TRUE(jobs_json(jobs, false).is_array());
  EXPECT_TRUE(jobs_json({}, true).is_array());
}

TEST(ServiceJson, AnEventKeepsItsFields) {
  // Goal: an event is printed as the run wrote it, including unknown fields, and with its job's id.
  // An invalid line is dropped. Method: print an unknown kind of event, and texts that aren't
  // objects.
  EXPECT_EQ(on_one_line(event_json({17}, R"({"number":3,"kind":"later","job":99,"x":[1]})")),
            R"({"job":17,"number":3,"kind":"later","x":[1]})");
  for (const char* line : {"", "[1]", "17", "{\"number\":", "\xff"})
    EXPECT_TRUE(event_json({17}, line).is_null()) << line;
}

TEST(ServiceJson, IsHarmlessOnATerminal) {
  // Goal: no text in the JSON can control a terminal. Method: put C0 and C1 control characters, a
  // bidirectional mark and invalid UTF-8 into a job's name.
  const rpc::JobView job{.id = {17}, .name = "\x1b[2J\u009b\u202e\x7f\xff\n"};
  for (const std::string& text : {indented(to_json(job, true)), on_one_line(to_json(job, true))}) {
    EXPECT_TRUE(std::ranges::all_of(text, [](char c) {
      return c == '\n' || (c >= 0x20 && c < 0x7f);
    })) << text;
  }
  EXPECT_EQ(on_one_line(to_json(job, true)).find('\n'), std::string::npos);
}

TEST(ServiceJson, AServerCountsJobsByState) {
  const Json json =
      server_report({.pid = 42,
                     .limits = {{"jobs", "100"}},
                     .counts = {{rpc::JobState::queued, 3}, {rpc::JobState::running, 1}}},
                    "/s")
          .as_json();
  EXPECT_EQ(json["pid"], 42);
  EXPECT_EQ(json["jobs"].dump(), R"({"queued":3,"running":1})");
  EXPECT_EQ(json["limits"]["jobs"], "100");
}

}  // namespace
}  // namespace sleight::cli
