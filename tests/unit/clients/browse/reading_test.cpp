// Goal: an index agrees with its archive, even if it extends an earlier index. The index's bytes
// read back equal or are rejected. Method: read in-memory archives of the made-up world. Then read
// longer archives of the same run. Change the bytes of an index.
#include "clients/browse/reading.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <variant>
#include <vector>

#include "clients/browse/index_bytes.h"
#include "common/archive/digest/digest.h"
#include "common/archive/format.h"
#include "common/archive/kept_motions.h"
#include "common/base/error.h"
#include "common/motion/path.h"
#include "tests/archive/memory_archive.h"
#include "tests/unit/clients/browse/random_index.h"
#include "tests/unit/common/archive/fake_world.h"

namespace sleight::browse {
namespace {

using archive::testing::FakeReader;
using archive::testing::FakeRun;
using archive::testing::FakeRunOptions;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Writes an archive that keeps all animations. If a run is longer, its archive begins with the
/// shorter run's animations.
void write(archive::MemoryArchive& memory, std::uint64_t scans, std::uint64_t seed = 1,
           std::uint64_t finds = 0) {
  const FakeRunOptions run{.seed = seed, .chains = 1, .scans = scans, .finds = finds};
  archive::write_digested(memory, [&](archive::Sink& sink) {
    archive::ArchiveOptions options = archive::testing::options_for(run);
    options.keep_max = 1000;
    options.keep_per_lineage = 1000;
    archive::write_archive(FakeRun(run), FakeReader(), options, sink);
  });
}

void expect_same(const Index& a, const Index& b) {
  EXPECT_EQ(a.run_id, b.run_id);
  EXPECT_EQ(a.digest, b.digest);
  EXPECT_EQ(a.world, b.world);
  EXPECT_EQ(a.numbers, b.numbers);
  ASSERT_EQ(a.entries.size(), b.entries.size());
  for (std::size_t i = 0; i < a.entries.size(); ++i)
    EXPECT_TRUE(a.entries[i] == b.entries[i]) << i;
}

Index index_of(const archive::Source& source) {
  auto read = read_index(source);
  EXPECT_TRUE(read.ok());
  return std::move(read).value().index;
}

TEST(Reading, SaysWhatTheArchiveSays) {
  archive::MemoryArchive memory;
  write(memory, 101, 1, 5);
  const Index index = index_of(memory);
  EXPECT_EQ(index.run_id, "fake run");
  EXPECT_EQ(index.world, "fake");
  std::vector<std::string> names;
  for (std::size_t i = k_own_numbers; i < index.numbers.size(); ++i)
    names.push_back(index.numbers[i].name);
  EXPECT_THAT(names,
              ElementsAre("landing_m", "bounces", "height_m", "normal_rad[0]", "normal_rad[1]",
                          "normal_rad[2]", "spin_radps[0,0]", "spin_radps[0,1]", "spin_radps[1,0]",
                          "spin_radps[1,1]", "spin_radps[2,0]", "spin_radps[2,1]"));
  std::size_t finds = 0;
  std::size_t contacts = 0;
  for (const Entry& entry : index.entries) {
    const std::string_view group = entry.name.is_find ? archive::k_finds : archive::k_animations;
    const archive::KeptMotions motions(memory, group);
    const auto animation = motions.animation(entry.row, index.scene);
    ASSERT_TRUE(animation.ok());
    finds += entry.name.is_find ? 1 : 0;
    contacts += entry.contacts.size();
    EXPECT_EQ(entry.end_s, animation.value().end_s());
    EXPECT_EQ(entry.pieces.size(), animation.value().segment_count());
    for (std::uint32_t body = 0; body < index.scene.bodies(); ++body) {
      for (double t_s = 0; t_s < 6; t_s += 0.37) {
        const auto centre = centre_at(entry.pieces_of(body), t_s);
        const auto& segments = animation.value().path(body).segments();
        const bool is_here = !segments.empty() && segments.front().start_s <= t_s;
        ASSERT_EQ(centre.has_value(), is_here);
        if (is_here) {
          EXPECT_LT((*centre - animation.value().path(body).pose_at(t_s)->centre_m).norm(), 1e-12);
        }
      }
    }
    const auto column = [&](const char* name) {
      return std::get<std::vector<double>>(memory.read(group, name, entry.row, 1)).front();
    };
    EXPECT_EQ(entry.numbers[k_log_prior], column("log_prior"));
    EXPECT_EQ(entry.numbers[k_own_numbers], column("landing_m"));
    EXPECT_EQ(entry.numbers[k_own_numbers + 2], column("height_m"));
  }
  EXPECT_EQ(finds, 5U);
  EXPECT_GT(contacts, 5U);
  EXPECT_GT(index.entries.size(), 15U);
}

TEST(Reading, GrowsWithItsRun) {
  archive::MemoryArchive shorter;
  archive::MemoryArchive longer;
  write(shorter, 60);
  write(longer, 200);
  const Index before = index_of(shorter);
  std::uint64_t read_to = 0;
  auto grown = read_index(
      longer, {.earlier = &before, .progress = [&](std::uint64_t done, std::uint64_t of) {
                 EXPECT_LE(done, of);
                 read_to = done;
               }});
  ASSERT_TRUE(grown.ok());
  EXPECT_EQ(grown.value().taken_over, before.entries.size());
  EXPECT_GT(grown.value().index.entries.size(), before.entries.size());
  EXPECT_EQ(read_to, grown.value().index.entries.size());
  expect_same(grown.value().index, index_of(longer));
  Index kept = grown.value().index;
  auto again = read_index(longer, {.of_this_file = &kept});
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(again.value().taken_over, grown.value().index.entries.size());
  expect_same(again.value().index, grown.value().index);
  EXPECT_TRUE(kept.entries.empty());
}

TEST(Reading, TakesNothingOfAFileThatOthersMayHaveChanged) {
  archive::MemoryArchive memory;
  write(memory, 80);
  const Index before = index_of(memory);
  // Another program may change positions without changing the animations' numbers and the digest.
  auto& places = std::get<std::vector<double>>(memory.values(archive::k_animations, "position_m"));
  for (double& place : places)
    place += 1;
  auto read = read_index(memory, {.earlier = &before});
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read.value().taken_over, 0U);
  for (const Entry& entry : read.value().index.entries) {
    for (const Piece& piece : entry.pieces)
      EXPECT_GE(piece.position_m.z(), 1);
  }
}

TEST(Reading, BoundsWhatAFileClaims) {
  for (const auto& [group, name] :
       {std::pair{archive::k_animations, "chain"}, std::pair{archive::k_animations, "draw"}}) {
    archive::MemoryArchive memory;
    write(memory, 80);
    std::get<std::vector<std::int64_t>>(memory.values(group, name)).front() = -1;
    try {
      static_cast<void>(read_index(memory));
      ADD_FAILURE() << name;
    } catch (const base::Error& error) {
      EXPECT_EQ(error.exit_code(), base::ExitCode::bad_archive);
      EXPECT_THAT(error.what(), HasSubstr("has a number below 0"));
    }
  }
}

TEST(Reading, BeginsAnewWhereDrawsBeginElsewhere) {
  archive::MemoryArchive memory;
  write(memory, 150);
  const Index whole = index_of(memory);
  // The earlier index lacks the first two animations.
  Index shifted = whole;
  shifted.digest = "another";
  shifted.entries.erase(shifted.entries.begin(), shifted.entries.begin() + 2);
  auto read = read_index(memory, {.earlier = &shifted});
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read.value().taken_over, 0U);
  expect_same(read.value().index, whole);
  // The reader doesn't reuse an index of another run or with other numbers, nor an index whose
  // contacts name missing features.
  for (int damage = 0; damage < 3; ++damage) {
    Index other = whole;
    if (damage == 0) other.run_id = "another";
    if (damage == 1) other.numbers.pop_back();
    if (damage == 2) other.entries[3].contacts.push_back({.body = 0, .partner = 77});
    auto of_other = read_index(memory, {.earlier = &other});
    ASSERT_TRUE(of_other.ok());
    EXPECT_EQ(of_other.value().taken_over, 0U);
    expect_same(of_other.value().index, whole);
  }
}

TEST(IndexBytes, ComeBackOrNotAtAll) {
  random::Stream stream({.seed = 29, .purpose = random::Purpose::prior}, 0);
  Index index = testing::random_index(9, stream);
  index.digest = "a digest";
  index.entries[4].name = {.run = "run", .is_find = true, .draw = 3};
  const base::Bytes bytes = bytes_of(index);
  const auto back = browse::index_of(bytes);
  ASSERT_TRUE(back.has_value());
  expect_same(*back, index);
  EXPECT_EQ(bytes_of(*back), bytes);
  const auto by_three = browse::index_of(bytes, 3);
  ASSERT_TRUE(by_three.has_value());
  expect_same(*by_three, index);
  for (std::size_t i = 0; i < bytes.size(); i += 1 + i / 16) {
    base::Bytes other = bytes;
    other[i] ^= std::byte{1} << (i % 8);
    EXPECT_FALSE(browse::index_of(other, 1 + i % 3).has_value()) << i;
    EXPECT_FALSE(browse::index_of(base::BytesView(bytes).first(i)).has_value()) << i;
  }
  base::Bytes more = bytes;
  more.push_back(std::byte{0});
  EXPECT_FALSE(browse::index_of(more).has_value());
}

TEST(Names, AreReadAsTheyAreWritten) {
  const AnimationName drawn{.run = "3f2a9c0111", .chain = 2, .draw = 250};
  const AnimationName found{.run = "3f2a9c0111", .is_find = true, .draw = 3};
  EXPECT_EQ(short_text(drawn), "c2.250");
  EXPECT_EQ(long_text(drawn), "3f2a9c01:c2.250");
  EXPECT_EQ(short_text(found), "find.3");
  for (const AnimationName& name : {drawn, found}) {
    const std::array texts{short_text(name), long_text(name)};
    for (const std::string& text : texts) {
      const auto asked = parse_name(text);
      ASSERT_TRUE(asked.has_value());
      EXPECT_EQ(asked->run, &text == &texts.front() ? "" : "3f2a9c01");
      EXPECT_EQ(asked->is_find, name.is_find);
      EXPECT_EQ(asked->chain, name.chain);
      EXPECT_EQ(asked->draw, name.draw);
    }
  }
  EXPECT_EQ(parse_name("3f2a9c02:c2.250")->run, "3f2a9c02");
  EXPECT_EQ(parse_name("3f2a9c01:2.250")->draw, 250U);
  EXPECT_TRUE(parse_name("2.250")->is_bare);
  EXPECT_FALSE(parse_name("c2.250")->is_bare);
  for (const char* text :
       {"", "c1", "c.1", "cc1.2", "c-1.2", "cfind.1", "1", "1.", ".1", "1.2.3", "find", "find.",
        "find.-1", "-1.2", "1.x", ":1.2", "1.99999999999999999999", "1. 2", "x:y:1.2"})
    EXPECT_FALSE(parse_name(text).has_value()) << text;
}

}  // namespace
}  // namespace sleight::browse
