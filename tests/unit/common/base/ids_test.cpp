#include "common/base/ids.h"

#include <gtest/gtest.h>

#include <concepts>
#include <limits>
#include <type_traits>

namespace sleight::base {
namespace {

// Ids of different kinds, and plain numbers, don't convert to each other implicitly.
static_assert(!std::same_as<ChainId, ReplicaId>);
static_assert(!std::convertible_to<ChainId, ReplicaId>);
static_assert(!std::constructible_from<ReplicaId, ChainId>);
static_assert(!std::equality_comparable_with<ChainId, ReplicaId>);
static_assert(!std::convertible_to<ChainId, std::uint32_t>);
static_assert(!std::convertible_to<std::uint32_t, ChainId>);
static_assert(std::same_as<ScanIndex::representation, std::uint64_t>);
static_assert(std::is_trivially_copyable_v<ScanIndex>);

TEST(Ids, PrintAsTheirNumber) {
  // Goal: an id is printed like its number, with the same format options.
  EXPECT_EQ(fmt::format("{}", ChainId{std::numeric_limits<std::uint32_t>::max()}), "4294967295");
  EXPECT_EQ(fmt::format("{}", ScanIndex{std::numeric_limits<std::uint64_t>::max()}),
            "18446744073709551615");
  EXPECT_EQ(fmt::format("{:04}", ReplicaId{7}), "0007");
}

}  // namespace
}  // namespace sleight::base
