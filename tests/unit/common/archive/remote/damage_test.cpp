// Goal: a program that reads a damaged file never hangs or crashes, and never takes the file for
// the original. Method: truncate a small archive, flip its bits, or overwrite parts of it. For each
// damaged file, the reader must report an error or findings, or return the original digest.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/archive/digest/digest.h"
#include "common/archive/digest/verify.h"
#include "common/archive/hdf5/writer.h"
#include "common/archive/remote/remote_source.h"
#include "common/base/error.h"
#include "tests/support/property.h"
#include "tests/unit/common/archive/fake_world.h"
#include "tests/unit/common/archive/hdf5/scratch.h"

namespace sleight::archive::remote {
namespace {

using archive::testing::mixed;

enum class Outcome { equal, found, refused };

class Damage : public archive::testing::Scratch {
 protected:
  Damage() {
    base::PosixFileSystem files;
    digest_ = hdf5::write_file(path("whole.h5"), files,
                               archive::testing::filler({.chains = 2, .scans = 3000, .thin = 100}));
    whole_ = bytes_of(path("whole.h5"));
  }

  Outcome outcome_of(const std::string& bytes) const {
    const std::string file = path("damaged.h5");
    put_bytes(file, bytes);
    try {
      const auto source = open_remote_by(SLEIGHT_READER, file, {.cpu_s = 20, .timeout_s = 30});
      if (!verify(*source).empty()) return Outcome::found;
      // The stored digest may be damaged, so compare with the original's digest.
      EXPECT_EQ(digest(*source), digest_);
      return Outcome::equal;
    } catch (const base::Error& error) {
      EXPECT_EQ(static_cast<int>(error.exit_code()), static_cast<int>(base::ExitCode::bad_archive))
          << error.what();
      EXPECT_THAT(error.what(), ::testing::StartsWith(file + ": "));
      return Outcome::refused;
    }
  }

  std::string digest_;
  std::string whole_;
};

TEST_F(Damage, WholeFilesAreEqual) {
  EXPECT_EQ(outcome_of(whole_), Outcome::equal);
}

TEST_F(Damage, TruncatedFilesAreRefused) {
  const std::size_t half = property::of_tier(10, 50);
  for (std::size_t i = 0; i < 2 * half; ++i) {
    const std::size_t length = i < half ? i * whole_.size() / half : whole_.size() - (i - half + 1);
    EXPECT_EQ(outcome_of(whole_.substr(0, length)), Outcome::refused) << length;
  }
}

TEST_F(Damage, FlippedBitsNeverPassForSound) {
  int equal = 0;
  int found = 0;
  int refused = 0;
  for (const std::uint64_t seed :
       property::cases(property::long_run() ? 5000 : property::of_tier(40, 300))) {
    std::string bytes = whole_;
    // In a third of the cases, flip a bit in the first 4 KiB, where the structures of HDF5 are
    // dense.
    const std::uint64_t place = mixed(seed) % (seed % 3 == 0 ? 4096 : bytes.size());
    bytes[place] = static_cast<char>(bytes[place] ^ (1 << mixed(seed + 7) % 8));
    const Outcome outcome = outcome_of(bytes);
    equal += outcome == Outcome::equal;
    found += outcome == Outcome::found;
    refused += outcome == Outcome::refused;
    ASSERT_FALSE(HasFailure()) << "seed " << seed << ", byte " << place;
  }
  if (!property::all_cases()) return;
  EXPECT_GT(equal, 0);
  EXPECT_GT(found, 0);
  EXPECT_GT(refused, 0);
  RecordProperty("equal", equal);
  RecordProperty("found", found);
  RecordProperty("refused", refused);
}

TEST_F(Damage, OverwrittenBlocksNeverPassForSound) {
  for (const std::uint64_t seed :
       property::cases(property::long_run() ? 1666 : property::of_tier(20, 200))) {
    std::string bytes = whole_;
    const std::uint64_t place = mixed(seed) % (bytes.size() - 512);
    for (std::size_t i = 0; i < 1 + mixed(seed + 1) % 512; ++i) {
      bytes[place + i] = seed % 2 == 0 ? '\0' : static_cast<char>(mixed(seed * 1000 + i));
    }
    outcome_of(bytes);
    ASSERT_FALSE(HasFailure()) << "seed " << seed << ", byte " << place;
  }
}

}  // namespace
}  // namespace sleight::archive::remote
