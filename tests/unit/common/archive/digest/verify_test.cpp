// Goal: verify() accepts sound archives and reports each kind of fault. Method: change one part of
// an in-memory archive and recompute the stored digest. verify() must report that change.
#include "common/archive/digest/verify.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/archive/digest/digest.h"
#include "common/archive/format.h"
#include "tests/archive/memory_archive.h"
#include "tests/unit/common/archive/fake_world.h"

namespace sleight::archive {
namespace {

using ::testing::Contains;
using testing::FakeRunOptions;
using testing::filler;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class Verify : public ::testing::Test {
 protected:
  Verify() { write_digested(archive_, filler(FakeRunOptions{})); }

  template <class Element>
  std::vector<Element>& values(std::string_view group, std::string_view name) {
    return std::get<std::vector<Element>>(archive_.values(group, name));
  }

  std::vector<std::string> findings() {
    for (Attribute& attribute : archive_.group(k_root).attributes) {
      if (attribute.name == k_content_digest) attribute.value = digest(archive_);
    }
    return verify(archive_);
  }

  MemoryArchive archive_;
};

TEST_F(Verify, SoundArchivesHaveNoFindings) {
  EXPECT_THAT(verify(archive_), IsEmpty());
  for (const std::uint64_t scans : {1U, 2U, 10U, 11U}) {
    for (const double share : {0.0, 1.0}) {
      MemoryArchive other;
      write_digested(other, filler({.chains = 1, .scans = scans, .satisfied_share = share}));
      EXPECT_THAT(verify(other), IsEmpty()) << scans;
    }
  }
}

TEST_F(Verify, AnyChangeBreaksTheDigest) {
  values<double>(k_posterior, "height_m")[2] += 1;
  EXPECT_THAT(verify(archive_), Contains(HasSubstr("content_digest")));
}

TEST_F(Verify, FindsHaveRules) {
  const auto broken = [this](auto&& change, const char* expected) {
    archive_ = MemoryArchive();
    write_digested(archive_, filler({.finds = 5}));
    EXPECT_THAT(verify(archive_), IsEmpty());
    change();
    EXPECT_THAT(findings(), Contains(HasSubstr(expected)));
  };
  const auto integers = [&](std::string_view name) -> auto& {
    return values<std::int64_t>(k_finds, name);
  };
  broken([&] { std::swap(integers("start")[1], integers("start")[2]); },
         "start numbers must increase");
  broken([&] { ++integers("segment_start")[3]; }, "segments in /finds must be contiguous");
  broken([&] { ++integers("segment_count")[4]; }, "segments in /finds must be contiguous");
  broken([&] { ++integers("animation")[0]; }, "/finds/animation must count");
  broken(
      [&] {
        for (Attribute& attribute : archive_.group(k_finds).attributes)
          if (attribute.name == k_found) attribute.value = std::int64_t{4};
      },
      "/finds has 5 animations; expected the smaller of its attributes found (4)");
}

TEST_F(Verify, NamesEachBrokenRule) {
  const auto broken = [this](auto&& change, const char* expected) {
    archive_ = MemoryArchive();
    write_digested(archive_, filler(FakeRunOptions{}));
    change();
    EXPECT_THAT(findings(), Contains(HasSubstr(expected)));
  };
  broken([&] { values<double>(k_sample_stats, "lp")[7] = 1; }, "lp = log_prior");
  broken([&] { values<std::int8_t>(k_sample_stats, "satisfied")[7] = 2; }, "0 or 1");
  broken([&] { values<std::int64_t>(k_sample_stats, "lineage")[7] = -1; }, "not be negative");
  broken([&] { values<std::int32_t>(k_sample_stats, "accepted")[9] = 99; }, "accepted <=");
  broken([&] { values<double>(k_sample_stats, "acceptance_rate")[9] = 7; }, "acceptance_rate =");
  broken([&] { values<std::int64_t>(k_sample_stats, "draw")[9] = 8; }, "count 0, 1");
  broken([&] { values<std::int64_t>(k_posterior, "draw")[3] = 31; }, "count 0, 10");
  broken([&] { values<std::int64_t>(k_replicas, "scan")[0] = 90; }, "last multiple of 'thin'");
  broken([&] { archive_.group(k_posterior).attributes[0].value = std::int64_t{0}; }, "thin is 0");
  broken([&] { archive_.group(k_posterior).attributes[0].value = std::int64_t{5}; }, "11 draws");
  auto place = [&](const char* name) -> auto& {
    return values<std::int64_t>(k_animations, name);
  };
  broken([&] { std::swap(place("draw")[3], place("draw")[15]); }, "ordered by draw");
  broken([&] { place("chain")[3] = 3; }, "exist in the run");
  broken([&] { place("lineage")[3] += 100; }, "equal the values of its scan");
  broken([&] { values<double>(k_animations, "landing_m")[3] = 7; }, "equal the values of its scan");
  broken([&] { place("segment_start")[3] += 1; }, "segments must be contiguous");
  broken([&] { place("segment_count")[19] -= 1; }, "segments must be contiguous");
  broken(
      [&] {
        const std::int64_t row = place("chain")[2] * 101 + place("draw")[2];
        values<std::int8_t>(k_sample_stats, "satisfied")[static_cast<std::size_t>(row)] = 0;
      },
      "a kept animation must satisfy");
  broken([&] { archive_.group(k_animations).attributes[0].value = std::int64_t{19}; },
         "keep_max is 19");
  const auto with_attribute = [&](const char* name, auto value) {
    return [&, name, value] { archive_.group(k_root).attributes.push_back({name, value}); };
  };
  broken(with_attribute("failed_work_limit", std::int64_t{0}), "integer above 0");
  broken(with_attribute("failed_work_limit", 1.0), "integer above 0");
  broken(with_attribute("failed_often", std::int64_t{1}), "unknown kind of failure");
  broken([&] { archive_.group(k_animations).attributes[1].value = std::int64_t{1}; },
         "at most keep_per_lineage");
}

TEST_F(Verify, NamesBrokenStructure) {
  const auto broken = [this](auto&& change, const char* expected) {
    archive_ = MemoryArchive();
    write_digested(archive_, filler(FakeRunOptions{}));
    change();
    EXPECT_THAT(verify(archive_), Contains(HasSubstr(expected)));
  };
  auto lp = [&]() -> DatasetSpec& { return archive_.group(k_sample_stats).datasets[2]; };
  ASSERT_EQ(lp().name, "lp");
  broken([&] { lp().name = "lq"; }, "/sample_stats/lp is missing");
  broken([&] { lp().type = ElementType::i64; }, "/sample_stats/lp is i64 over (chain, draw)");
  broken([&] { lp().dims[1].name = "scan"; }, "no coordinate");
  const auto retyped = [&](std::string_view group, std::string_view name, ElementType type) {
    return [&, group, name, type] {
      std::ranges::find(archive_.group(group).datasets, name, &DatasetSpec::name)->type = type;
    };
  };
  broken(retyped(k_animations, "axis_xyz", ElementType::text), "/animations/axis_xyz is text");
  broken(retyped(k_scene, "axis_xyz", ElementType::text), "/scene/axis_xyz is text, expected i64");
  broken(retyped(k_posterior, "axis", ElementType::f64), "/posterior/axis is f64, expected i64");
  broken([&] { archive_.group(k_replicas).name = "/copies"; }, "/replicas is missing");
  broken([&] { archive_.group(k_root).attributes[1].value = std::int64_t{4}; }, "format_version");
  broken([&] { archive_.group(k_animations).attributes.clear(); }, "keep_per_lineage is missing");
  broken(
      [&] {
        archive_.group(k_posterior)
            .datasets.back()
            .dims.erase(archive_.group(k_posterior).datasets.back().dims.begin());
      },
      "a variable of a world");
}

}  // namespace
}  // namespace sleight::archive
