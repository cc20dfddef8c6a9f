// A lookup table for first contacts: maps a pair of features to its position in the list.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace sleight::browse {

inline constexpr std::size_t k_first_contacts_max = 256;

/// Hash table with open addressing and linear probes; at most a quarter full.
class ContactPlaces {
 public:
  static constexpr std::uint32_t k_none = 0xffffffff;

  ContactPlaces() { keys_.fill(k_free); }
  /// REQUIRES: the pair isn't in the table, and the table has fewer than k_first_contacts_max
  /// pairs.
  void add(std::uint32_t low, std::uint32_t high, std::uint32_t place) {
    const std::size_t slot = slot_of(key_of(low, high));
    keys_[slot] = key_of(low, high);
    places_[slot] = place;
  }
  /// Returns k_none if the pair isn't in the table.
  std::uint32_t find(std::uint32_t low, std::uint32_t high) const {
    const std::size_t slot = slot_of(key_of(low, high));
    return keys_[slot] == k_free ? k_none : places_[slot];
  }

 private:
  static constexpr std::size_t k_bits = 10;
  static constexpr std::size_t k_slots = std::size_t{1} << k_bits;
  static_assert(k_slots >= 4 * k_first_contacts_max);
  static constexpr std::uint64_t k_free = ~std::uint64_t{0};

  static std::uint64_t key_of(std::uint32_t low, std::uint32_t high) {
    return std::uint64_t{low} << 32U | high;
  }
  /// Returns the key's slot, or the free slot in which it would be stored.
  std::size_t slot_of(std::uint64_t key) const {
    // The upper bits of a product depend on all bits of the key (Knuth, TAOCP 3, 6.4).
    std::size_t slot = key * 0x9e3779b97f4a7c15U >> (64U - k_bits);
    while (keys_[slot] != key && keys_[slot] != k_free)
      slot = (slot + 1) % k_slots;
    return slot;
  }

  std::array<std::uint64_t, k_slots> keys_;
  std::array<std::uint32_t, k_slots> places_{};
};

}  // namespace sleight::browse
