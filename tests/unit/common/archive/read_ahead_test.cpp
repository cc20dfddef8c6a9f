// Goal: ReadAhead returns the values and errors of its source. If many small reads follow each
// other, ReadAhead makes only a few reads of the source. Method: compare random reads with the
// source. Count the source's reads, and damage one element.
#include "common/archive/read_ahead.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <memory>
#include <utility>
#include <variant>
#include <vector>

#include "common/archive/format.h"
#include "common/base/error.h"
#include "common/random/stream.h"
#include "tests/archive/memory_archive.h"
#include "tests/unit/common/archive/fake_world.h"

namespace sleight::archive {
namespace {

/// Forwards and counts reads. Refuses reads that include the damaged element.
class Counting final : public Source {
 public:
  Counting(const Source& source, std::uint64_t damage, std::uint64_t& asked)
      : source_(source), damage_(damage), asked_(asked) {}
  std::string name() const override { return source_.name(); }
  const std::vector<Group>& groups() const override { return source_.groups(); }
  Values read(std::string_view group, std::string_view dataset, std::uint64_t first,
              std::uint64_t count) const override {
    ++asked_;
    if (first <= damage_ && damage_ < first + count)
      throw base::Error(base::ExitCode::bad_archive, "damaged");
    return source_.read(group, dataset, first, count);
  }

 private:
  const Source& source_;
  std::uint64_t damage_;
  std::uint64_t& asked_;
};

constexpr std::uint64_t k_nowhere = ~std::uint64_t{0};
constexpr std::string_view k_group = k_sample_stats;

class ReadAheadTest : public ::testing::Test {
 protected:
  ReadAheadTest() {
    testing::FakeRunOptions options;
    options.scans = 20'001;
    testing::filler(options)(memory_);
  }
  std::uint64_t elements() const {
    return element_count(*find_dataset(*find_group(memory_, k_group), "lp"));
  }
  Values truth(std::uint64_t first, std::uint64_t count) const {
    return memory_.read(k_group, "lp", first, count);
  }

  MemoryArchive memory_;
  std::uint64_t asked_ = 0;
};

bool are_same(const Values& a, const Values& b) {
  const auto& of_a = std::get<std::vector<double>>(a);
  const auto& of_b = std::get<std::vector<double>>(b);
  return of_a.size() == of_b.size() &&
         std::equal(of_a.begin(), of_a.end(), of_b.begin(), [](double x, double y) {
           return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
         });
}

TEST_F(ReadAheadTest, GivesWhatTheSourceHas) {
  const ReadAhead ahead(std::make_unique<Counting>(memory_, k_nowhere, asked_));
  ASSERT_GT(elements(), 3 * k_read_ahead);
  random::Stream stream({.seed = 1, .purpose = random::Purpose::prior}, 0);
  std::uint64_t first = 0;
  for (int i = 0; i < 20'000; ++i) {
    // Most reads begin where the last read ended; a few begin at a random place.
    if (stream.uniform() < 0.02 || first >= elements())
      first = static_cast<std::uint64_t>(stream.uniform() * static_cast<double>(elements()));
    const auto wanted = static_cast<std::uint64_t>(stream.uniform() * 40);
    const std::uint64_t count = std::min(wanted, elements() - first);
    ASSERT_TRUE(are_same(ahead.read(k_group, "lp", first, count), truth(first, count))) << first;
    first += count;
  }
  EXPECT_TRUE(are_same(ahead.read(k_group, "lp", 0, elements()), truth(0, elements())));
}

TEST_F(ReadAheadTest, NothingHasItsTypeToo) {
  const ReadAhead ahead(std::make_unique<Counting>(memory_, k_nowhere, asked_));
  for (const std::uint64_t first : {0U, 7U, 0U}) {
    EXPECT_TRUE(
        std::get<std::vector<std::int64_t>>(ahead.read(k_group, "lineage", first, 0)).empty());
    EXPECT_EQ(ahead.read(k_group, "lineage", first, 3), memory_.read(k_group, "lineage", first, 3));
  }
}

TEST_F(ReadAheadTest, AsksSeldomInARow) {
  const ReadAhead ahead(std::make_unique<Counting>(memory_, k_nowhere, asked_));
  for (std::uint64_t first = 0; first + 10 <= elements(); first += 10)
    static_cast<void>(ahead.read(k_group, "lp", first, 10));
  EXPECT_LE(asked_, 2 + elements() / k_read_ahead);
  // If reads are scattered, each causes at most one read of the source.
  asked_ = 0;
  for (const std::uint64_t first : {5000U, 100U, 9000U, 40U})
    static_cast<void>(ahead.read(k_group, "lp", first, 10));
  EXPECT_LE(asked_, 4U);
}

TEST_F(ReadAheadTest, ReadsAroundDamage) {
  constexpr std::uint64_t k_damage = 1005;
  const ReadAhead ahead(std::make_unique<Counting>(memory_, k_damage, asked_));
  for (std::uint64_t first = 0; first < 2000; first += 10) {
    if (first <= k_damage && k_damage < first + 10) {
      EXPECT_THROW(ahead.read(k_group, "lp", first, 10), base::Error);
    } else {
      EXPECT_TRUE(are_same(ahead.read(k_group, "lp", first, 10), truth(first, 10)));
    }
  }
}

}  // namespace
}  // namespace sleight::archive
