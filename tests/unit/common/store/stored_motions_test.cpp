// Goal: a motion that is stored beside a run's store reads back bit for bit or not at all.
#include "common/store/stored_motions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "common/motion/fields.h"
#include "common/store/database.h"
#include "tests/unit/common/store/examples.h"

namespace sleight::store {
namespace {

archive::Motion motion_of(int number) {
  if (number % 5 == 4) return {.ends = archive::PlaysOut::failed};
  if (number % 5 == 3) return {.ends = archive::PlaysOut::otherwise};
  archive::Motion motion;
  for (int i = 0; i < number % 7; ++i) {
    const math::Vec3 some(number / 3.0, i + 0.1, -1e300 * number);
    motion.segments.push_back({.body = static_cast<std::uint32_t>(number),
                               .start_s = -0.0,
                               .mode = static_cast<motion::Mode>(i % 4),
                               .cause = static_cast<motion::Cause>((i + number) % 4),
                               .partner = i - 1,
                               .position_m = some,
                               .velocity_mps = 2 * some,
                               .acceleration_mps2 = 3 * some,
                               .orientation = {0.1 * i, -0.2, number / 7.0, 1},
                               .angular_velocity_radps = 4 * some,
                               .angular_acceleration_radps2 = 5 * some});
  }
  if (number % 7 > 0)
    motion.segments.back().angular_acceleration_radps2.z() =
        std::bit_cast<double>(0x7ff8000000000123ULL);
  return motion;
}

base::Bytes state_of(int number) {
  base::ByteWriter writer;
  writer.put(number);
  return writer.take();
}

bool same(const archive::Motion& a, const archive::Motion& b) {
  const auto bits = [](const archive::Motion& motion) {
    std::vector<std::uint64_t> all;
    for (const motion::Segment& segment : motion.segments) {
      motion::for_each_field(motion::k_fields, [&](const auto& field) {
        for (const auto element : motion::elements_of(segment.*field.member))
          all.push_back(std::bit_cast<std::uint64_t>(static_cast<double>(element)));
      });
    }
    return all;
  };
  return a.ends == b.ends && bits(a) == bits(b);
}

class StoredMotionsTest : public testing::RunFolder {
 protected:
  StoredMotionsTest() { std::filesystem::create_directories(folder()); }
  /// Returns how many of the first 50 motions are stored, and checks their bits.
  int remembered(const std::string& owner) const {
    StoredMotions motions(folder(), owner);
    int count = 0;
    for (int number = 0; number < 50; ++number) {
      const auto known = motions.find(state_of(number));
      if (!known) continue;
      EXPECT_TRUE(same(*known, motion_of(number))) << number;
      ++count;
    }
    return count;
  }
  void keep_fifty(const std::string& owner) const {
    StoredMotions motions(folder(), owner);
    for (int number = 0; number < 50; ++number)
      motions.keep(state_of(number), motion_of(number));
    EXPECT_TRUE(same(motions.find(state_of(7)).value(), motion_of(7)));  // still in memory
  }
  void execute(const std::string& sql) const {
    Database(StoredMotions::path(folder()), Access::read_write).execute(sql);
  }
};

TEST_F(StoredMotionsTest, ComeBackBitForBit) {
  // Goal: another process reads stored motions unchanged, including NaN payloads, signed zeros and
  // failed motions. Method: write fifty motions with one object, and read them with another object.
  EXPECT_EQ(remembered("a"), 0);
  keep_fifty("a");
  EXPECT_EQ(remembered("a"), 50);
}

TEST_F(StoredMotionsTest, BelongToOneOwner) {
  // Goal: if motions belong to another version or request, they are never returned. The new owner's
  // motions replace them. Method: open the file with another owner's text, and store motions of the
  // same states.
  keep_fifty("a");
  EXPECT_EQ(remembered("b"), 0);
  EXPECT_EQ(remembered("a"), 50);
  keep_fifty("b");
  EXPECT_EQ(remembered("b"), 50);
  EXPECT_EQ(remembered("a"), 0);
}

TEST_F(StoredMotionsTest, WhatIsDamagedIsForgotten) {
  // Goal: a damaged row is never returned. If the file is damaged or deleted, it is created again.
  // Method: change one column in each of several rows. Replace the file by garbage. Delete the
  // file.
  keep_fifty("a");
  int left = 50;
  // Each change affects the motion of one state. The motion has segments. The second text is the
  // first byte (of four) of the state.
  const std::vector<std::pair<std::string, std::string>> changes{{"ends=2", "01"},
                                                                 {"columns=4", "02"},
                                                                 {"numbers=zeroblob(24)", "05"},
                                                                 {"numbers=zeroblob(7)", "06"},
                                                                 {"checksum=7", "08"}};
  for (const auto& [change, number] : changes) {
    execute("UPDATE motion SET " + change + " WHERE state=x'" + number + "000000'");
    EXPECT_EQ(remembered("a"), --left) << change;
  }
  keep_fifty("a");
  EXPECT_EQ(remembered("a"), 50);
  put_bytes(StoredMotions::path(folder()), std::string(5000, 'x'));
  EXPECT_EQ(remembered("a"), 0);
  keep_fifty("a");
  EXPECT_EQ(remembered("a"), 50);
  std::filesystem::remove(StoredMotions::path(folder()));
  EXPECT_EQ(remembered("a"), 0);
}

TEST_F(StoredMotionsTest, AFileDamagedWithinIsMadeAnew) {
  // Goal: if the damage of a file is found while rows are read or written, the file is created
  // again without an error. Method: overwrite all pages but the first. The old motions are lost,
  // and new motions must be stored.
  keep_fifty("a");
  execute("PRAGMA wal_checkpoint(TRUNCATE)");
  std::string bytes = bytes_of(StoredMotions::path(folder()));
  ASSERT_GT(bytes.size(), 8192U);
  std::fill(bytes.begin() + 4096, bytes.end(), 'x');
  put_bytes(StoredMotions::path(folder()), bytes);
  {
    StoredMotions motions(folder(), "a");
    EXPECT_FALSE(motions.find(state_of(3)).has_value());
    motions.keep(state_of(3), motion_of(3));
  }
  EXPECT_EQ(remembered("a"), 1);
}

TEST_F(StoredMotionsTest, GrowsToItsBound) {
  // Goal: a file grows beyond its size limit only by the motions that wait to be written. Stored
  // motions stay. Method: use a limit of 1 MB and motions of 100 kB.
  StoredMotions motions(folder(), "a", 1 << 20);
  const archive::Motion large{.segments = std::vector<motion::Segment>(521)};
  for (int number = 0; number < 400; ++number)
    motions.keep(state_of(number), large);
  const std::string file = StoredMotions::path(folder());
  EXPECT_LT(std::filesystem::file_size(file) + std::filesystem::file_size(file + "-wal"),
            k_motions_bytes + (2U << 20U));
  EXPECT_TRUE(motions.find(state_of(0)).has_value());
  EXPECT_FALSE(motions.find(state_of(399)).has_value());
}

TEST_F(StoredMotionsTest, WithoutAFileNothingIsRemembered) {
  // Goal: if the file can't be created, calls succeed and no motion is found.
  StoredMotions motions(folder() + "/nowhere", "a");
  motions.keep(state_of(1), motion_of(1));
  EXPECT_FALSE(motions.find(state_of(1)).has_value());
}

TEST_F(StoredMotionsTest, TwoMayHaveOneFile) {
  // Goal: a checkpoint and `archive derive` can share one file of motions at the same time. Method:
  // let two objects write to one file.
  StoredMotions one(folder(), "a");
  {
    StoredMotions other(folder(), "a");
    for (int number = 0; number < 25; ++number)
      other.keep(state_of(number), motion_of(number));
    for (int number = 20; number < 50; ++number)
      one.keep(state_of(number), motion_of(number));
  }
  EXPECT_TRUE(one.find(state_of(3)).has_value());
  { StoredMotions third(folder(), "a"); }
  EXPECT_TRUE(one.find(state_of(49)).has_value());
}

}  // namespace
}  // namespace sleight::store
