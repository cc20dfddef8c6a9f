// Goal: a store accepts results only of its own run and only from the run's newest session. Method:
// open stores with other identities. Open two stores of one run at once.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "common/base/error.h"
#include "common/store/damage.h"
#include "common/store/run_store.h"
#include "tests/unit/common/store/examples.h"

namespace sleight::store {
namespace {

using testing::example_identity;
using testing::expect_stored;
using ::testing::HasSubstr;
using testing::result_of;

class RunStoreSessions : public testing::RunFolder {
 protected:
  static std::string failure_of(base::ExitCode code, const std::function<void()>& act) {
    try {
      act();
    } catch (const base::Error& error) {
      EXPECT_EQ(error.exit_code(), code) << error.what();
      return error.what();
    }
    ADD_FAILURE() << "no error";
    return {};
  }
  std::string conflict_of(const RunIdentity& identity) const {
    return failure_of(base::ExitCode::conflict, [&] { RunStore(folder(), identity); });
  }
  void execute(const std::string& sql) const {
    Database(RunStore::database_path(folder()), Access::read_write).execute(sql);
  }
};

TEST_F(RunStoreSessions, BelongToOneRequestAndOneResultsVersion) {
  // Goal: no store mixes two requests, versions or formats (invariant 3), and the error names a
  // remedy. Method: change the request, the version and the format in turn, and open the store each
  // time. Then the original run must find its scans unchanged.
  {
    RunStore store(folder(), example_identity(1));
    store.put(result_of(0, 0, 4));
  }
  RunIdentity other_request = example_identity(1);
  other_request.identity_text += " ";
  EXPECT_THAT(conflict_of(other_request),
              AllOf(HasSubstr(folder()), HasSubstr("another request"), HasSubstr("--fresh")));
  RunIdentity other_version = example_identity(1);
  other_version.results_version = "r2";
  other_version.program_version = "1.1";
  EXPECT_THAT(conflict_of(other_version),
              AllOf(HasSubstr("version r1 (sleight 1.0)"), HasSubstr("version r2 (sleight 1.1)"),
                    HasSubstr("--fresh")));
  execute("UPDATE run SET value=7 WHERE key='format_version'");
  EXPECT_THAT(conflict_of(example_identity(1)),
              AllOf(HasSubstr("format 7"), HasSubstr("writes format 6")));
  execute("UPDATE run SET value=6 WHERE key='format_version'");

  // A later program version may resume the run if it has the same results version.
  RunIdentity later_program = example_identity(1);
  later_program.program_version = "1.1";
  RunStore store(folder(), later_program);
  EXPECT_EQ(store.epoch(), 2U);
  expect_stored(folder(), store, 0, 4);
}

TEST_F(RunStoreSessions, MayStopElsewhere) {
  // Goal: between sessions, a request may change keys that are not part of its identity, such as
  // [stop]. Method: open the store again with another request text. The store must then contain the
  // new text.
  { RunStore(folder(), example_identity(1)); }
  RunIdentity longer = example_identity(1);
  longer.request_text += "# more\n";
  { RunStore(folder(), longer); }
  Database database(RunStore::database_path(folder()), Access::read_only);
  Statement select = database.prepare("SELECT value FROM run WHERE key='request'");
  ASSERT_TRUE(select.step());
  EXPECT_EQ(select.text(0), longer.request_text);
}

TEST_F(RunStoreSessions, NewerOneFencesTheOlder) {
  // Goal: once the successor of a session that was presumed dead has begun, the old session stores
  // nothing more. Method: open a second store of the same run. The first store's next commit and
  // later puts must fail with a conflict.
  RunStore first(folder(), example_identity(2));
  first.put(result_of(0, 0, 5));
  first.flush();
  RunStore second(folder(), example_identity(2));
  EXPECT_EQ(second.epoch(), first.epoch() + 1);
  first.put(result_of(0, 5, 5));
  first.put(result_of(1, 0, 5));
  EXPECT_THAT(failure_of(base::ExitCode::conflict, [&] { first.flush(); }),
              AllOf(HasSubstr(folder()), HasSubstr("epoch 2"), HasSubstr("epoch 1")));
  (void)failure_of(base::ExitCode::conflict, [&] { first.put(result_of(0, 10, 5)); });
  EXPECT_EQ(first.committed(), 5U);
  expect_stored(folder(), second, 0, 5);
  expect_stored(folder(), second, 1, 0);

  second.put(result_of(0, 5, 3));
  second.flush();
  expect_stored(folder(), second, 0, 8);
  expect_stored(folder(), second, 1, 0);
}

TEST_F(RunStoreSessions, RefusedOneFencesNobody) {
  // Goal: if a session is refused because its request differs, the running session continues.
  RunStore running(folder(), example_identity(1));
  RunIdentity other = example_identity(1);
  other.identity_text = "another";
  (void)conflict_of(other);
  running.put(result_of(0, 0, 5));
  running.flush();
  expect_stored(folder(), running, 0, 5);
}

TEST_F(RunStoreSessions, SeeNoHalfOfAUnit) {
  // Goal: a reader sees either all scans of a unit or none. Method: poll the store while units of
  // 40 scans are committed. The number of scans must be a multiple of 40 and equal the stored
  // progress.
  RunStore store(folder(), example_identity(1));
  Database reader(RunStore::database_path(folder()), Access::read_only);
  Statement count = reader.prepare(
      "SELECT (SELECT count(*) FROM scan), (SELECT coalesce(max(next_scan), 0) FROM replica)");
  for (std::uint64_t scan = 0; scan < 4000; scan += 40) {
    store.put(result_of(0, scan, 40));
    if (scan % 400 == 0) store.flush();
    ASSERT_TRUE(count.step());
    EXPECT_EQ(count.integer(0) % 40, 0);
    EXPECT_EQ(count.integer(0), count.integer(1));
    count.reset();
  }
}

TEST_F(RunStoreSessions, NeedAFolderAndADatabase) {
  // Goal: opening a store fails if the folder is missing or the store's file isn't a database. The
  // file stays unchanged.
  const std::string missing = failure_of(base::ExitCode::environment,
                                         [&] { RunStore(path("missing"), example_identity(1)); });
  EXPECT_THAT(missing, HasSubstr(path("missing")));
  EXPECT_FALSE(tells_of_damage(missing)) << missing;
  const std::string text(8192, 't');
  put_bytes(RunStore::database_path(folder()), text);
  const std::string no_store =
      failure_of(base::ExitCode::environment, [&] { RunStore(folder(), example_identity(1)); });
  EXPECT_THAT(no_store, HasSubstr("not a run store"));
  EXPECT_TRUE(tells_of_damage(no_store)) << no_store;
  EXPECT_EQ(bytes_of(RunStore::database_path(folder())), text);
}

}  // namespace
}  // namespace sleight::store
