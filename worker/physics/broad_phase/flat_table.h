// A hash table in one array, with open addressing and linear probing. Allocates only to grow.
//
// Idea. Removing an entry closes the gap (Knuth, The Art of Computer Programming, vol. 3, 6.4,
// Algorithm R). So removed entries leave no marks, and the speed depends only on present entries.
//
// Invariants
//   1. At most 5/8 of the slots are taken.
//   2. The hash of a key selects a slot, the entry's home. No slot between the home and the entry
//      is free.
// The entries can't be iterated, because their order would depend on the hash. Thread safety: none.
#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace sleight::physics {

/// A key that no entry may have.
inline constexpr std::uint64_t k_no_key = UINT64_MAX;

template <class T>
concept TableSlot = std::default_initializable<T> && requires(T slot) {
  { slot.key } -> std::same_as<std::uint64_t&>;
} && T {
}
.key == k_no_key;

template <TableSlot Slot>
class FlatTable {
 public:
  explicit FlatTable(std::size_t entries = 0) {
    slots_.resize(std::bit_ceil(entries * 8 / 5 + 16));
    set_shift();
  }

  std::size_t size() const { return size_; }

  /// Returns the entry, or null. The pointer is valid until the next insert or erase.
  Slot* find(std::uint64_t key) {
    Slot& slot = slots_[place_of(key)];
    return slot.key == key ? &slot : nullptr;
  }
  const Slot* find(std::uint64_t key) const {
    const Slot& slot = slots_[place_of(key)];
    return slot.key == key ? &slot : nullptr;
  }
  bool contains(std::uint64_t key) const { return slots_[place_of(key)].key == key; }

  /// Returns the key's entry, and whether it is new. REQUIRES: the key is not k_no_key.
  std::pair<Slot*, bool> insert(std::uint64_t key) {
    std::size_t place = place_of(key);
    if (slots_[place].key == key) return {&slots_[place], false};
    if ((size_ + 1) * 8 > slots_.size() * 5) {
      grow();
      place = place_of(key);
    }
    ++size_;
    slots_[place].key = key;
    return {&slots_[place], true};
  }

  /// Returns whether the key had an entry.
  bool erase(std::uint64_t key) {
    std::size_t gap = place_of(key);
    if (slots_[gap].key != key) return false;
    --size_;
    // Close the gap: each later entry moves into the gap, unless the entry's home is behind the
    // gap.
    for (std::size_t place = next(gap); slots_[place].key != k_no_key; place = next(place)) {
      const std::size_t from_home = (place - home_of(slots_[place].key)) & (slots_.size() - 1);
      const std::size_t from_gap = (place - gap) & (slots_.size() - 1);
      if (from_home < from_gap) continue;
      slots_[gap] = slots_[place];
      gap = place;
    }
    slots_[gap] = Slot{};
    return true;
  }

 private:
  std::size_t next(std::size_t place) const { return (place + 1) & (slots_.size() - 1); }
  // Multiplies by an odd number (64 bits of the golden ratio), mixes in the upper half, and
  // multiplies by another odd number (from SplitMix64). High and low parts of the key affect the
  // top bits, which select the slot.
  std::size_t home_of(std::uint64_t key) const {
    key *= 0x9e3779b97f4a7c15U;
    key ^= key >> 32;
    return static_cast<std::size_t>(key * 0xbf58476d1ce4e5b9U >> shift_);
  }
  /// Returns the key's slot. If the key is absent, returns the free slot for the key.
  std::size_t place_of(std::uint64_t key) const {
    std::size_t place = home_of(key);
    while (slots_[place].key != key && slots_[place].key != k_no_key)
      place = next(place);
    return place;
  }
  void set_shift() { shift_ = 64 - std::countr_zero(slots_.size()); }
  void grow() {
    std::vector<Slot> old(slots_.size() * 2);
    old.swap(slots_);
    set_shift();
    for (const Slot& slot : old) {
      if (slot.key != k_no_key) slots_[place_of(slot.key)] = slot;
    }
  }

  std::vector<Slot> slots_;  ///< size: a power of two
  std::size_t size_ = 0;
  int shift_ = 0;
};

}  // namespace sleight::physics
