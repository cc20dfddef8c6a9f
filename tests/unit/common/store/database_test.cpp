#include "common/store/database.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "common/base/error.h"
#include "tests/unit/common/archive/hdf5/scratch.h"

namespace sleight::store {
namespace {

using ::testing::HasSubstr;

class DatabaseOf : public archive::testing::Scratch {};

TEST_F(DatabaseOf, ValuesComeBack) {
  // Goal: every kind of value reads back as it was stored. Method: store extreme numbers, a text
  // with a zero byte, an empty blob and NULL.
  Database database(path("a.sqlite"), Access::read_write);
  database.execute("CREATE TABLE t(i INTEGER, r REAL, t TEXT, b BLOB NOT NULL, n BLOB)");
  Statement insert = database.prepare("INSERT INTO t VALUES(?1,?2,?3,?4,?5)");
  const std::string text("a\0b", 3);
  insert.bind(1, std::numeric_limits<std::int64_t>::min());
  insert.bind(2, -std::numeric_limits<double>::infinity());
  insert.bind(3, std::string_view(text)).bind(4, base::BytesView()).bind_null(5).run();

  Statement select = database.prepare("SELECT * FROM t");
  ASSERT_TRUE(select.step());
  EXPECT_EQ(select.integer(0), std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(select.real(1), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(select.text(2), text);
  EXPECT_TRUE(select.blob(3).empty());
  EXPECT_TRUE(select.blob(4).empty());
  EXPECT_FALSE(select.step());
}

TEST_F(DatabaseOf, IsDurableByItsSettings) {
  // Goal: finished commits survive a loss of power. Method: check SQLite's settings for the journal
  // and for synchronous writes.
  Database database(path("a.sqlite"), Access::read_write);
  Statement journal = database.prepare("PRAGMA journal_mode");
  ASSERT_TRUE(journal.step());
  EXPECT_EQ(journal.text(0), "wal");
  Statement synchronous = database.prepare("PRAGMA synchronous");
  ASSERT_TRUE(synchronous.step());
  EXPECT_EQ(synchronous.integer(0), 2);
}

TEST_F(DatabaseOf, ErrorsNameTheFileAndWhatToDo) {
  // Goal: each error of the database names the file, the rule that was broken, or the remedy.
  const auto failure = [](const auto& act) -> std::string {
    try {
      act();
    } catch (const base::Error& error) {
      EXPECT_EQ(error.exit_code(), base::ExitCode::environment);
      return error.what();
    }
    ADD_FAILURE() << "no error";
    return {};
  };
  const std::string missing = path("missing.sqlite");
  EXPECT_THAT(failure([&] { Database(missing, Access::read_only); }), HasSubstr(missing));
  EXPECT_THAT(failure([&] { Database(path("x/y.sqlite"), Access::read_write); }),
              HasSubstr("folder exists"));
  put_bytes(path("text"), std::string(5000, 'x'));
  EXPECT_THAT(failure([&] { Database(path("text"), Access::read_write); }),
              AllOf(HasSubstr(path("text")), HasSubstr("--fresh")));

  Database database(path("a.sqlite"), Access::read_write);
  EXPECT_THAT(failure([&] { database.execute("NONSENSE"); }), HasSubstr("a.sqlite"));
  EXPECT_THAT(failure([&] { (void)database.prepare("SELECT nothing"); }), HasSubstr("a.sqlite"));
  database.execute("CREATE TABLE t(a NOT NULL)");
  Statement insert = database.prepare("INSERT INTO t VALUES(?1)");
  EXPECT_THAT(failure([&] { insert.bind_null(1).run(); }), HasSubstr("NOT NULL"));
  insert.bind(1, std::int64_t{1}).run();
}

TEST_F(DatabaseOf, DeathTestNotANumberIsABug) {
  // Goal: binding NaN is a bug, because SQLite would silently store NULL.
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  Database database(path("a.sqlite"), Access::read_write);
  Statement select = database.prepare("SELECT ?1");
  EXPECT_DEATH(select.bind(1, std::numeric_limits<double>::quiet_NaN()), "check failed");
}

}  // namespace
}  // namespace sleight::store
