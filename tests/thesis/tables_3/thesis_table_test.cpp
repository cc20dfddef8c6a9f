// Goal: the thesis's numbers are read as they stand, and a table that is missing or damaged is an
// error that names the place: a column of ours never stands beside an empty one.
// Method: the project's own files against numbers of the thesis; files with one fault each.
#include "tests/thesis/tables_3/thesis_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "common/base/error.h"

namespace sleight::thesis {
namespace {

const std::string k_folder = SLEIGHT_TABLES_3;

/// What reading a file with this text is refused with; empty if it is taken.
std::string refusal(const std::string& text) {
  const std::string path = testing::TempDir() + "thesis_table_test.csv";
  std::ofstream(path) << text;
  try {
    read_thesis_table(path);
  } catch (const base::Error& error) {
    return error.what();
  }
  return {};
}

std::string table_of(const std::string& rows) {
  return "# source\n" + std::string(k_heading) + "\n" + rows;
}

TEST(ThesisTable, HasTheThesisNumbers) {
  const auto box = read_thesis_table(k_folder + "/table_3_1.csv");
  ASSERT_EQ(box.size(), 12U);
  EXPECT_EQ(row_of(box, 64, "box").sync.events, 8'999'377);  // table 3.1, last row
  EXPECT_NEAR(row_of(box, 64, "box").speed_up(), 12.1, 0.05);
  const auto funnel = read_thesis_table(k_folder + "/table_3_2.csv");
  ASSERT_EQ(funnel.size(), 10U);
  EXPECT_EQ(row_of(funnel, 10, "funnel").async.total_s, 8.118);  // table 3.2, first row
}

TEST(ThesisTable, IsAnErrorWhereItIsMissing) {
  EXPECT_THROW(read_thesis_table(k_folder + "/table_3_3.csv"), base::Error);
  EXPECT_THROW(read_thesis_table("/nowhere/table_3_1.csv"), base::Error);
  const auto box = read_thesis_table(k_folder + "/table_3_1.csv");
  EXPECT_THROW(row_of(box, 5, "box"), base::Error);
}

TEST(ThesisTable, IsAnErrorWhereItIsDamaged) {
  const std::string good = "1,1000,2,2,1000,3,3\n";
  EXPECT_EQ(refusal(table_of(good)), "");
  const struct {
    std::string text;
    const char* said;
  } cases[] = {
      {"", "has no rows"},
      {table_of(""), "has no rows"},
      {good, ":1: "},
      {"# source\nn,sync_events\n" + good, ":2: "},
      {table_of("1,1000,2,2,1000,3\n"), ":3: "},
      {table_of("1,1000,2,2,1000,3,3,4\n"), ":3: "},
      {table_of("1,1000,2,,1000,3,3\n"), ":3: "},
      {table_of("1,1000,2,2,1000,3,nan\n"), ":3: "},
      {table_of("1.5,1000,2,2,1000,3,3\n"), ":3: "},
      {table_of("1,1000,2,2,1000,3,-3\n"), ":3: "},
      {table_of(good + "\n"), ":4: "},
      {table_of(good + good), "does not grow"},
      {table_of("1,1000,2,2.1,1000,3,3\n"), "do not fit"},
      {table_of("1,1000,2,2,1100,3,3\n"), "do not fit"},
  };
  for (const auto& each : cases)
    EXPECT_THAT(refusal(each.text), testing::HasSubstr(each.said)) << each.text;
}

}  // namespace
}  // namespace sleight::thesis
