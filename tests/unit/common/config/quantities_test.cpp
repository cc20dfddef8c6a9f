// Goal: sizes and times are read in the forms that people write, and other texts are refused.
// Written sizes and times read back equal.
#include "common/config/quantities.h"

#include <gtest/gtest.h>

namespace sleight::config {
namespace {

TEST(Quantities, SizesAreRead) {
  EXPECT_EQ(bytes_of("17"), 17U);
  EXPECT_EQ(bytes_of("17 B"), 17U);
  EXPECT_EQ(bytes_of("24 GB"), 24'000'000'000U);
  EXPECT_EQ(bytes_of("24gb"), 24'000'000'000U);
  EXPECT_EQ(bytes_of("1.5 GiB"), 1'610'612'736U);
  EXPECT_EQ(bytes_of("0"), 0U);
  EXPECT_EQ(bytes_of("9007199254740992"), k_bytes_max);
}

TEST(Quantities, OtherTextIsNoSize) {
  for (const char* text : {"", " ", "GB", "-1 GB", "1  GB", "1 XB", "1 GB ", "10000 TB", "nan",
                           "inf", "1e3 GB", "0x10", "24 GB/s"}) {
    EXPECT_FALSE(bytes_of(text).has_value()) << text;
  }
}

TEST(Quantities, TimesAreRead) {
  EXPECT_EQ(duration_s_of("90"), 90.0);
  EXPECT_EQ(duration_s_of("90s"), 90.0);
  EXPECT_EQ(duration_s_of("5m"), 300.0);
  EXPECT_EQ(duration_s_of("1.5h"), 5400.0);
  for (const char* text : {"", "0", "-5s", "5d", "5m5s", "nan", "inf", "1e300h", "99999999999"})
    EXPECT_FALSE(duration_s_of(text).has_value()) << text;
}

TEST(Quantities, WrittenSizesReadBack) {
  EXPECT_EQ(bytes_text(50'000'000'000), "50 GB");
  EXPECT_EQ(bytes_text(1'500'000), "1500 kB");
  EXPECT_EQ(bytes_text(0), "0 B");
  for (std::uint64_t bytes = 1; bytes <= k_bytes_max; bytes = bytes * 10 / 3 + 1) {
    EXPECT_EQ(bytes_of(bytes_text(bytes)), bytes) << bytes_text(bytes);
    const std::uint64_t round = bytes / 1000 * 1000;
    EXPECT_EQ(bytes_of(bytes_text(round)), round) << bytes_text(round);
  }
  for (const double duration_s : {1.0, 10.0, 59.5, 60.0, 90.0, 3600.0, 5400.0, 1e9})
    EXPECT_EQ(duration_s_of(duration_text(duration_s)), duration_s) << duration_text(duration_s);
}

}  // namespace
}  // namespace sleight::config
