// Goal: no bytes crash decode(). decode() refuses an input with a reason or returns a valid
// message. Method: cut messages, change their bits or words, or join two messages. Use random
// bytes. If a message is accepted, it must stay equal when it is encoded and decoded again.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstring>

#include "common/random/discrete_distributions.h"
#include "common/random/stream.h"
#include "common/schema/wire/wire.h"
#include "tests/support/property.h"
#include "tests/unit/common/schema/wire/examples.h"

namespace sleight::schema::wire {
namespace {

constexpr std::uint64_t k_seed = 20240611;

std::uint64_t inputs() {
  return property::of_tier(3'000, 20'000);
}

std::size_t below(std::size_t count, random::Stream& stream) {
  return random::UniformInteger{.count = count}.draw(stream);
}

/// Returns short messages. A random change hits a short message's structure about as often as its
/// content.
std::vector<base::Bytes> short_messages() {
  std::vector<base::Bytes> all;
  for (const Message& message : testing::examples()) {
    base::Bytes bytes = encode(message);
    if (bytes.size() < 4000) all.push_back(std::move(bytes));
  }
  return all;
}

base::Bytes mutated(const std::vector<base::Bytes>& good, random::Stream& stream) {
  base::Bytes bytes = good[below(good.size(), stream)];
  switch (below(5, stream)) {
    case 0:  // cut, mostly at a whole number of words
      bytes.resize(below(bytes.size() + 1, stream) & ~(below(4, stream) == 0 ? 0U : 7U));
      break;
    case 1:  // change a few bits
      for (std::size_t i = below(4, stream) + 1; i > 0; --i) {
        bytes[below(bytes.size(), stream)] ^= std::byte{1} << below(8, stream);
      }
      break;
    case 2: {  // replace a word by noise, zeros or ones
      const std::size_t at = below(bytes.size() / 8, stream) * 8;
      const std::size_t kind = below(3, stream);
      const std::uint64_t word = kind == 0 ? stream.bits() : kind == 1 ? 0 : ~std::uint64_t{0};
      std::memcpy(bytes.data() + at, &word, 8);
      break;
    }
    case 3: {  // join two messages
      const base::Bytes& other = good[below(good.size(), stream)];
      const std::size_t at = below(std::min(bytes.size(), other.size()) / 8, stream) * 8;
      bytes.resize(at);
      bytes.insert(bytes.end(), other.begin() + static_cast<std::ptrdiff_t>(at), other.end());
      break;
    }
    default:  // noise after a plausible head (one segment of the right length)
      for (std::size_t i = 8; i < bytes.size(); ++i)
        bytes[i] = static_cast<std::byte>(stream.bits());
  }
  return bytes;
}

void expect_well_formed(const plan::Block& block) {
  ASSERT_GE(block.members.size(), 1U);
  for (const plan::Unit& unit : block.members) {
    EXPECT_GE(unit.scans, 1U);
    EXPECT_TRUE(unit.inverse_temperatures.size() == 1 ||
                unit.inverse_temperatures.size() == unit.scans);
    if (block.ladder) {
      EXPECT_EQ(unit.scans, 1U);
    }
  }
  if (!block.ladder) {
    EXPECT_EQ(block.members.size(), 1U);
    return;
  }
  EXPECT_EQ(block.ladder->inverse_temperatures.size(), block.members.size());
  EXPECT_EQ(block.ladder->proposal_scales.size(), block.members.size());
  EXPECT_LE(std::uint64_t{block.ladder->first_level} + block.members.size(), block.ladder->levels);
}

void expect_well_formed(const Message& message) {
  if (const auto* hello = std::get_if<Hello>(&message)) {
    EXPECT_GE(hello->threads, 1U);
  }
  if (const auto* delivery = std::get_if<Delivery>(&message)) {
    for (const plan::UnitResult& result : delivery->results) {
      EXPECT_GE(result.scans.size(), 1U);
      EXPECT_EQ(result.scans.size(), result.unit.scans);
      for (const plan::FailedSimulation& failed : result.failed)
        EXPECT_LT(static_cast<std::size_t>(failed.failure.kind), plan::k_failure_kinds);
    }
  }
  if (const auto* assignment = std::get_if<Assignment>(&message)) {
    expect_well_formed(assignment->block);
    EXPECT_EQ(assignment->states.size(), assignment->block.members.size());
  }
  const auto back = decode(encode(message));
  ASSERT_TRUE(back.ok()) << back.error();
  EXPECT_TRUE(testing::same_bits(back.value(), message));
}

TEST(HostileMessages, AreRefusedOrWellFormed) {
  const std::vector<base::Bytes> good = short_messages();
  std::uint64_t accepted = 0;
  for (const std::uint64_t input : property::cases(inputs())) {
    random::Stream stream({.seed = k_seed, .purpose = random::Purpose::prior}, input);
    const auto message = decode(mutated(good, stream));
    if (message.ok()) {
      ++accepted;
      expect_well_formed(message.value());
    } else {
      EXPECT_FALSE(message.error().empty());
    }
    if (::testing::Test::HasFailure()) return;
  }
  if (!property::all_cases()) return;
  EXPECT_GT(accepted, inputs() / 100);
  EXPECT_LT(accepted, inputs() - inputs() / 100);
}

TEST(HostileMessages, EveryCutIsRefused) {
  // Goal: every incomplete message is refused.
  for (const base::Bytes& whole : short_messages()) {
    for (std::size_t size = 0; size < whole.size(); ++size) {
      EXPECT_FALSE(decode(base::BytesView(whole).first(size)).ok()) << size;
    }
  }
}

TEST(HostileMessages, NoiseIsRefusedOrWellFormed) {
  // Goal: decode() refuses random bytes or returns a valid message. Method: decode up to 60 words
  // of random bytes. Half of the inputs begin with a head that states the right length.
  for (const std::uint64_t input : property::cases(inputs())) {
    random::Stream stream({.seed = k_seed, .purpose = random::Purpose::proposal}, input);
    base::Bytes bytes(below(480, stream));
    for (std::byte& byte : bytes)
      byte = static_cast<std::byte>(stream.bits());
    if (below(2, stream) == 0 && bytes.size() >= 8) {
      bytes.resize(bytes.size() & ~std::size_t{7});
      const std::uint64_t head = std::uint64_t{bytes.size() / 8 - 1} << 32U;
      std::memcpy(bytes.data(), &head, 8);
    }
    const auto message = decode(bytes);
    if (message.ok()) {
      expect_well_formed(message.value());
    } else {
      EXPECT_FALSE(message.error().empty());
    }
    if (::testing::Test::HasFailure()) return;
  }
}

TEST(HostileMessages, ListsOfNothingCostLittle) {
  // Goal: a short message can't claim to contain a list of hundreds of millions of empty elements.
  // Method: replace each word of a message by a pointer to such a list.
  const Message claimants[] = {testing::example_delivery({1}), testing::example_delivery({1, 2}),
                               testing::example_assignment(3),
                               Pong{.epoch = 1, .assignments = {1, 2, 3}}};
  for (const Message& claimant : claimants) {
    const base::Bytes good = encode(claimant);
    for (std::size_t at = 8; at + 8 <= good.size(); at += 8) {
      for (const std::uint64_t element_size : {0U, 7U}) {
        base::Bytes bytes = good;
        // A list pointer consists of its kind (1), an offset (0), the element size and the element
        // count.
        const std::uint64_t pointer =
            1U | (element_size << 32U) | (std::uint64_t{0x1fffffff} << 35U);
        std::memcpy(bytes.data() + at, &pointer, 8);
        const auto message = decode(bytes);
        if (message.ok()) expect_well_formed(message.value());
      }
    }
  }
}

}  // namespace
}  // namespace sleight::schema::wire
