// Goal: a record is read back as it was written and is never incomplete. Space is reserved for the
// attempt's end.
#include "service/keeper/attempt_record.h"

#include <gtest/gtest.h>

#include <fstream>
#include <optional>
#include <string>

#include "common/base/error.h"
#include "tests/unit/common/base/faulty_file_system.h"
#include "tests/unit/service/keeper/job.h"

namespace sleight::keeper {
namespace {

using base::testing::FaultyFileSystem;
using base::testing::FileCall;

AttemptRecord begun() {
  return {.attempt = 3,
          .keeper = {.pid = 4711, .start_ticks = 123456789, .boot = "a-b-c"},
          .command = {"/bin/sleight", "direct", "a \"b\"\n.toml"},
          .begun_unix_s = 1.7e9 + 0.25,
          .epoch_before = 2};
}

AttemptRecord ended() {
  AttemptRecord record = begun();
  record.end = AttemptEnd{.exit_code = 130,
                          .killed_for = KilledFor::lingering,
                          .stop_asked = Stop::in_order,
                          .run_end = events::RunEnd{.epoch = 3,
                                                    .end = events::End::stop_requested,
                                                    .exit_code = base::ExitCode::interrupted,
                                                    .scans = 17,
                                                    .digest = "abc"},
                          .wall_s = 1.5,
                          .processor_s = 2.75,
                          .memory_bytes_max = 1U << 30U,
                          .ended_unix_s = 1.7e9 + 2,
                          .log_tail = {"one", "", "three"}};
  return record;
}

TEST(AttemptRecord, IsReadAsItWasWritten) {
  EXPECT_EQ(record_of(to_text(begun())), begun());
  EXPECT_EQ(record_of(to_text(ended())), ended());
  AttemptRecord other = begun();
  other.end = AttemptEnd{.signal = 9, .killed_for = KilledFor::asked, .stop_asked = Stop::now};
  EXPECT_EQ(record_of(to_text(other)), other);
  other.end = AttemptEnd{.not_started = "no such file"};
  EXPECT_EQ(record_of(to_text(other)), other);
}

TEST(AttemptRecord, AnythingElseIsNone) {
  // Method: cut a record at each byte. In other copies, rename one field, or change its type or
  // value.
  const std::string text = to_text(ended());
  for (std::size_t size = 0; size + 1 < text.size(); ++size)
    ASSERT_EQ(record_of(text.substr(0, size)), std::nullopt) << size;
  for (const auto& [from, to] :
       {std::pair<std::string, std::string>{"\"format\":1", "\"format\":2"},
        {"\"attempt\":3", "\"attempt\":\"3\""},
        {"\"pid\"", "\"pidx\""},
        {"\"lingering\"", "\"bored\""},
        {"\"in_order\"", "\"soon\""},
        {"\"run_end\":\"{", "\"run_end\":\"["},
        {"\"log_tail\":[\"one\"", "\"log_tail\":[1"}}) {
    std::string changed = text;
    const std::size_t place = changed.find(from);
    ASSERT_NE(place, std::string::npos) << from;
    changed.replace(place, from.size(), to);
    EXPECT_EQ(record_of(changed), std::nullopt) << changed;
  }
  EXPECT_EQ(record_of("[]"), std::nullopt);
  EXPECT_EQ(record_of("null"), std::nullopt);
}

TEST(AttemptRecord, StaysUnderItsBound) {
  // Goal: whatever the program's output and command, the record fits into its reserved space.
  // Method: use long commands and the longest log tail. Each character of the tail takes six bytes
  // in JSON.
  AttemptRecord record = ended();
  record.end->log_tail.assign(k_tail_lines_max, std::string(400, '\x01'));
  std::string text = to_text(record);
  EXPECT_LE(text.size(), k_record_bytes_max);
  auto read = record_of(text);
  ASSERT_TRUE(read);
  EXPECT_FALSE(read->end->log_tail.empty());
  record.command.assign(1000, std::string(5000, 'x'));
  record.end->not_started = std::string(100'000, 'y');
  text = to_text(record);
  EXPECT_LE(text.size(), k_record_bytes_max);
  ASSERT_TRUE(record_of(text));
}

class RecordFileTest : public testing::JobTest {};

TEST_F(RecordFileTest, NothingIsThereUntilItIsWhole) {
  // Goal: if a file call fails while a record is written, the folder has either the old or the new
  // record. Method: let each file call fail in turn.
  EXPECT_EQ(read_record(folder()), std::nullopt);
  AttemptRecord before = begun();
  before.attempt = 2;
  for (const bool is_end : {false, true}) {
    bool has_failed = true;
    for (std::uint64_t good = 0; has_failed; ++good) {
      FaultyFileSystem files;
      RecordFile(files, folder()).begin(before);
      RecordFile file(files, folder());
      if (is_end) file.begin(begun());
      files.fail({.after = good, .reason = std::errc::no_space_on_device});
      try {
        if (is_end) {
          file.end(ended());
        } else {
          file.begin(begun());
        }
      } catch (const base::Error&) {
      }
      has_failed = files.failures() > 0;
      const auto found = read_record(folder());
      const auto& old = is_end ? begun() : before;
      const auto& now = is_end ? ended() : begun();
      EXPECT_TRUE(found == now || (has_failed && found == old)) << good;
      ASSERT_LT(good, 100U);
    }
  }
}

TEST_F(RecordFileTest, WhatIsNoneOfOursIsSaid) {
  // Goal: if a record is damaged, it never counts as missing. Reading the record throws an error
  // that names the file.
  std::ofstream(path(k_record_name)) << "{\"attempt\":1";
  try {
    static_cast<void>(read_record(folder()));
    FAIL();
  } catch (const base::Error& error) {
    EXPECT_NE(std::string(error.what()).find("attempt.json"), std::string::npos) << error.what();
  }
  std::ofstream(path(k_record_name)) << std::string(k_record_bytes_max + 1, ' ');
  EXPECT_THROW(static_cast<void>(read_record(folder())), base::Error);
}

}  // namespace
}  // namespace sleight::keeper
