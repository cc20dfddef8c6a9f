#include "common/base/bytes.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <vector>

namespace sleight::base {
namespace {

template <class T>
std::optional<T> read_one(BytesView bytes) {
  ByteReader reader(bytes);
  return reader.get<T>();
}

TEST(Bytes, ComeBackAsTheyWerePut) {
  // Goal: numbers of every size read back in the order in which they were written, and doubles keep
  // all bits. Method: use doubles that easily lose bits: a NaN with a payload, negative zero and
  // infinity.
  const double payload = std::bit_cast<double>(std::uint64_t{0x7ff4'0000'dead'beef});
  ByteWriter writer;
  writer.put(std::uint8_t{200});
  writer.put(std::int32_t{-7});
  writer.put(std::numeric_limits<std::uint64_t>::max());
  writer.put(payload);
  writer.put(-0.0);
  writer.put(-std::numeric_limits<double>::infinity());
  const Bytes bytes = writer.take();
  ASSERT_EQ(bytes.size(), 1U + 4 + 8 + 3 * 8);

  ByteReader reader(bytes);
  EXPECT_EQ(reader.get<std::uint8_t>(), 200);
  EXPECT_EQ(reader.get<std::int32_t>(), -7);
  EXPECT_EQ(reader.get<std::uint64_t>(), std::numeric_limits<std::uint64_t>::max());
  for (const double expected : {payload, -0.0, -std::numeric_limits<double>::infinity()}) {
    EXPECT_FALSE(reader.at_end());
    const std::optional<double> value = reader.get<double>();
    ASSERT_TRUE(value.has_value());
    EXPECT_EQ(std::bit_cast<std::uint64_t>(*value), std::bit_cast<std::uint64_t>(expected));
  }
  EXPECT_TRUE(reader.at_end());
}

TEST(Bytes, AreLittleEndian) {
  // Goal: numbers are stored in little-endian order on every machine.
  ByteWriter writer;
  writer.put(std::uint32_t{0x04030201});
  EXPECT_EQ(writer.take(), (Bytes{std::byte{1}, std::byte{2}, std::byte{3}, std::byte{4}}));
}

TEST(Bytes, EndWithoutAValue) {
  // Goal: no read goes beyond the end, and a failed read consumes no bytes. Method: use each length
  // up to two words. Read as many words as possible, then single bytes.
  for (std::size_t size = 0; size <= 16; ++size) {
    const Bytes bytes(size, std::byte{9});
    ByteReader reader(bytes);
    std::size_t words = 0;
    while (reader.get<std::uint64_t>())
      ++words;
    EXPECT_EQ(words, size / 8);
    EXPECT_EQ(reader.get<std::uint64_t>(), std::nullopt);
    std::size_t rest = 0;
    while (reader.get<std::uint8_t>())
      ++rest;
    EXPECT_EQ(rest, size % 8);
    EXPECT_TRUE(reader.at_end());
  }
  EXPECT_EQ(read_one<double>({}), std::nullopt);
  EXPECT_EQ(read_one<std::uint8_t>({}), std::nullopt);
}

TEST(Bytes, AreReadAtAnyAddress) {
  // Goal: a double can be read at any address, without alignment.
  for (std::size_t offset = 0; offset < 8; ++offset) {
    ByteWriter writer;
    for (std::size_t i = 0; i < offset; ++i)
      writer.put(std::uint8_t{0});
    writer.put(0.1);
    const Bytes bytes = writer.take();
    EXPECT_EQ(read_one<double>(BytesView(bytes).subspan(offset)), 0.1);
  }
}

TEST(Bytes, OfArraysAreTheirContent) {
  // Goal: bytes_of() returns the bytes of all elements, and no bytes for an empty span.
  const std::vector<std::uint32_t> values{1, 0xffffffffU, 3};
  ByteReader reader(bytes_of(std::span(values)));
  for (const std::uint32_t value : values)
    EXPECT_EQ(reader.get<std::uint32_t>(), value);
  EXPECT_TRUE(reader.at_end());
  EXPECT_TRUE(bytes_of(std::span<const double>()).empty());
}

}  // namespace
}  // namespace sleight::base
