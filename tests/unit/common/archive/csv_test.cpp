// Goal: a CSV table has a named column for each variable, and its numbers read back equal. Method:
// export the tables of an in-memory archive. Parse the CSV, and compare its values with the
// archive's values.
#include "common/archive/csv.h"

#include <gtest/gtest.h>

#include <sstream>

#include "common/archive/digest/digest.h"
#include "common/archive/format.h"
#include "common/base/error.h"
#include "tests/archive/memory_archive.h"
#include "tests/unit/common/archive/fake_world.h"

namespace sleight::archive {
namespace {

std::vector<std::string> lines_of(const Source& source, std::string_view table) {
  std::ostringstream out;
  export_csv(source, table, out);
  std::istringstream in(out.str());
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);)
    lines.push_back(line);
  return lines;
}

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields{""};
  bool quoted = false;
  for (const char letter : line) {
    if (letter == '"') {
      quoted = !quoted;
    } else if (letter == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += letter;
    }
  }
  return fields;
}

class Csv : public ::testing::Test {
 protected:
  Csv() { write_digested(archive_, testing::filler({.scans = 25})); }
  MemoryArchive archive_;
};

TEST_F(Csv, RowsOfSomeAnimations) {
  const auto all = lines_of(archive_, "segments");
  const auto starts =
      std::get<std::vector<std::int64_t>>(archive_.read(k_animations, "segment_start", 0, 2));
  const auto counts =
      std::get<std::vector<std::int64_t>>(archive_.read(k_animations, "segment_count", 0, 2));
  const std::uint64_t asked[] = {1, 0};
  std::ostringstream out;
  export_csv(archive_, "segments", out, asked);
  std::string expected = all[0] + "\n";
  for (const std::uint64_t animation : asked) {
    for (std::int64_t row = 0; row < counts[animation]; ++row)
      expected += all[static_cast<std::size_t>(1 + starts[animation] + row)] + "\n";
  }
  EXPECT_EQ(out.str(), expected);
  const std::uint64_t none[] = {1'000'000};
  EXPECT_THROW(export_csv(archive_, "segments", out, none), base::Error);
  EXPECT_THROW(export_csv(archive_, "animations", out, none), base::Error);
  const auto rows = lines_of(archive_, "animations");
  std::ostringstream table;
  export_csv(archive_, "animations", table, asked);
  EXPECT_EQ(table.str(), rows[0] + "\n" + rows[2] + "\n" + rows[1] + "\n");
  EXPECT_THROW(export_csv(archive_, "posterior", out, asked), base::Error);
}

TEST_F(Csv, PosteriorHasARowForEachDraw) {
  const auto lines = lines_of(archive_, "posterior");
  ASSERT_EQ(lines.size(), 1U + 3 * 3);
  EXPECT_EQ(lines[0],
            "chain,draw,height_m,normal_rad[0],normal_rad[1],normal_rad[2],\"spin_radps[0,0]\","
            "\"spin_radps[0,1]\",\"spin_radps[1,0]\",\"spin_radps[1,1]\",\"spin_radps[2,0]\","
            "\"spin_radps[2,1]\"");
  const auto spins = std::get<std::vector<double>>(archive_.read(k_posterior, "spin_radps", 0, 54));
  for (std::size_t row = 0; row < 9; ++row) {
    const auto fields = fields_of(lines[row + 1]);
    ASSERT_EQ(fields.size(), 12U);
    EXPECT_EQ(fields[0], std::to_string(row / 3));
    EXPECT_EQ(fields[1], std::to_string(row % 3 * 10));
    for (std::size_t i = 0; i < 6; ++i)
      EXPECT_EQ(std::stod(fields[6 + i]), spins[row * 6 + i]);
  }
}

TEST_F(Csv, ColumnsHaveTheNamesOfIndices) {
  MemoryArchive named;
  write_digested(named, testing::filler<testing::NamedReader>({.scans = 25}));
  const std::string header = lines_of(named, "posterior")[0];
  EXPECT_TRUE(
      header.starts_with("chain,draw,height_m,normal_rad[first],"
                         "\"normal_rad[a \"\"gro\xc3\x9f\"\", [b]]\",normal_rad[xxx"))
      << header;
}

TEST_F(Csv, SampleStatsNameProposalKinds) {
  const auto lines = lines_of(archive_, "sample_stats");
  ASSERT_EQ(lines.size(), 1U + 3 * 25);
  EXPECT_EQ(lines[0],
            "chain,draw,lp,log_prior,log_constraint,satisfied,lineage,proposed[all],"
            "proposed[one_normal],accepted[all],accepted[one_normal],acceptance_rate,landing_m,"
            "bounces");
  EXPECT_EQ(fields_of(lines[1])[11].substr(0, 3), "nan");
}

TEST_F(Csv, AnimationsAndSegmentsAreSeparateTables) {
  const auto animations = lines_of(archive_, "animations");
  EXPECT_EQ(animations.size(),
            1 + find_dataset(*find_group(archive_, k_animations), "animation")->dims[0].size);
  EXPECT_TRUE(animations[0].starts_with("animation,chain,draw,lineage,in_proportion,log_prior"));
  const auto segments = lines_of(archive_, "segments");
  EXPECT_EQ(segments[0],
            "segment,body,start_s,mode,cause,partner,position_m[0],position_m[1],position_m[2],"
            "velocity_mps[0],velocity_mps[1],velocity_mps[2],acceleration_mps2[0],"
            "acceleration_mps2[1],acceleration_mps2[2],orientation[0],orientation[1],"
            "orientation[2],orientation[3],angular_velocity_radps[0],angular_velocity_radps[1],"
            "angular_velocity_radps[2],angular_acceleration_radps2[0],"
            "angular_acceleration_radps2[1],angular_acceleration_radps2[2]");
  EXPECT_EQ(segments.size(),
            1 + find_dataset(*find_group(archive_, k_animations), "segment")->dims[0].size);
}

TEST_F(Csv, LongTablesAreWrittenInBatches) {
  MemoryArchive longer;
  write_digested(longer, testing::filler({.chains = 2, .scans = 20000}));
  const auto lines = lines_of(longer, "sample_stats");
  ASSERT_EQ(lines.size(), 40001U);
  EXPECT_TRUE(lines[40000].starts_with("1,19999,"));
}

TEST_F(Csv, UnknownTablesAreRefused) {
  try {
    lines_of(archive_, "none");
    FAIL() << "not refused";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.exit_code(), base::ExitCode::usage);
    EXPECT_NE(std::string(error.what()).find("posterior, sample_stats"), std::string::npos);
  }
}

TEST_F(Csv, MissingGroupsAreRefused) {
  archive_.group(k_replicas).name = "/other";
  EXPECT_THROW(lines_of(archive_, "replicas"), base::Error);
}

}  // namespace
}  // namespace sleight::archive
