// Goal: a supervisor can read from a run's store how each session ended.
#include "common/store/sessions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/error.h"
#include "common/store/run_store.h"
#include "tests/unit/common/store/examples.h"

namespace sleight::store {
namespace {

using testing::example_identity;
using ::testing::HasSubstr;
using testing::result_of;

class Sessions : public testing::RunFolder {
 protected:
  void execute(const std::string& sql) const {
    Database(RunStore::database_path(folder()), Access::read_write).execute(sql);
  }
  std::string failure() const {
    try {
      (void)sessions_of(folder());
    } catch (const base::Error& error) {
      return error.what();
    }
    return {};
  }
};

TEST_F(Sessions, TellHowEachEnded) {
  // Goal: sessions_of() returns each session with the number of scans before it. If a session
  // finished or failed, it has an end. If a session died or is running, it has no end. Method: let
  // one session die before a commit and one after a commit. Let other sessions fail, finish and
  // run.
  { RunStore died(folder(), example_identity(1)); }
  {
    RunStore died(folder(), example_identity(1));
    died.put(result_of(0, 0, 4));
  }
  const events::RunEnd full{
      .end = events::End::failed, .exit_code = base::ExitCode::environment, .words = "disk full"};
  {
    RunStore failed(folder(), example_identity(1));
    failed.close(full);
  }
  RunIdentity later = example_identity(1);
  later.program_version = "1.1";
  const events::RunEnd done{.epoch = 99, .end = events::End::finished, .scans = 9, .digest = "ab"};
  {
    RunStore finished(folder(), later);
    finished.put(result_of(0, 4, 5));
    finished.close(done);
    EXPECT_EQ(sessions_of(folder()).back().end->epoch, 4U);
  }
  const RunStore running(folder(), later);

  events::RunEnd failed_end = full;
  failed_end.epoch = 3;
  events::RunEnd finished_end = done;
  finished_end.epoch = 4;
  EXPECT_EQ(sessions_of(folder()),
            (std::vector<Session>{
                {.epoch = 1, .program_version = "1.0"},
                {.epoch = 2, .program_version = "1.0"},
                {.epoch = 3, .program_version = "1.0", .end = failed_end, .scans_before = 4},
                {.epoch = 4, .program_version = "1.1", .end = finished_end, .scans_before = 4},
                {.epoch = 5, .program_version = "1.1", .scans_before = 9}}));
}

TEST_F(Sessions, OneThatWasTakenForDeadSaysNothing) {
  // Goal: if a session's successor has begun, the session stores no end, and the successor's end
  // stays. Method: open two stores of one run, and close the older store first.
  RunStore older(folder(), example_identity(1));
  RunStore newer(folder(), example_identity(1));
  try {
    older.close({.end = events::End::finished});
    ADD_FAILURE() << "it was recorded";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.exit_code(), base::ExitCode::conflict);
    EXPECT_THAT(error.what(), HasSubstr("newer session (epoch 2)"));
  }
  newer.close({.end = events::End::time_limit});
  const std::vector<Session> sessions = sessions_of(folder());
  ASSERT_EQ(sessions.size(), 2U);
  EXPECT_FALSE(sessions[0].end.has_value());
  EXPECT_EQ(sessions[1].end->end, events::End::time_limit);
}

TEST_F(Sessions, WhatWasChangedIsRefused) {
  // Goal: if a row is damaged, sessions_of() throws, so a supervisor never acts on it. Method:
  // change each column in turn.
  {
    RunStore store(folder(), example_identity(1));
    store.close({.end = events::End::finished, .scans = 10});
  }
  EXPECT_EQ(failure(), "");
  for (const char* change :
       {"program_version='2'", "scans_before=1", "ended=''", "ended=replace(ended, '10', '11')",
        "ended='x'", "epoch=2", "checksum=checksum+1"}) {
    execute("CREATE TABLE copy AS SELECT * FROM session");
    execute(std::string("UPDATE session SET ") + change);
    EXPECT_THAT(failure(), HasSubstr("damaged: the end of session")) << change;
    execute("DELETE FROM session");
    execute("INSERT INTO session SELECT * FROM copy");
    execute("DROP TABLE copy");
  }
  EXPECT_EQ(failure(), "");
}

}  // namespace
}  // namespace sleight::store
