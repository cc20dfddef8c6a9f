// Values by place in the grid, made when they are first asked for.
//
// Thread safety: none.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "worker/physics/surface/surface_controls.h"

namespace sleight::physics {

/// References to values hold until the next one is made.
template <class Value>
class GridTable {
 public:
  /// Room for so many before anything is allocated: a power of two.
  explicit GridTable(std::size_t room) : slots_(2 * room) { values_.reserve(room); }

  std::size_t size() const { return values_.size(); }

  /// The value there; make(index) if there is none yet.
  template <class Make>
  const Value& at(GridIndex index, const Make& make) {
    if (last_ != k_none && index == last_index_) return values_[last_];
    const std::size_t mask = slots_.size() - 1;
    std::size_t place = hash_of(index) & mask;
    while (slots_[place].number != k_none && slots_[place].index != index)
      place = (place + 1) & mask;
    std::uint32_t number = slots_[place].number;
    if (number == k_none) {
      // Making may fail: no slot names a value before it is there.
      Value made = make(index);
      number = static_cast<std::uint32_t>(values_.size());
      values_.push_back(std::move(made));
      slots_[place] = {index, number};
    }
    last_ = number;
    last_index_ = index;
    if (2 * values_.size() > slots_.size()) grow();
    return values_[last_];
  }

 private:
  /// Open addressing; a slot of no value has number k_none.
  struct Slot {
    GridIndex index;
    std::uint32_t number = k_none;
  };
  static constexpr std::uint32_t k_none = UINT32_MAX;

  static std::size_t hash_of(GridIndex index) {
    const auto i = static_cast<std::uint64_t>(static_cast<std::uint32_t>(index.i));
    const auto j = static_cast<std::uint64_t>(static_cast<std::uint32_t>(index.j));
    return static_cast<std::size_t>(((i << 32U | j) * 0x9e3779b97f4a7c15U) >> 32U);
  }
  void grow() {
    std::vector<Slot> old(2 * slots_.size());
    old.swap(slots_);
    const std::size_t mask = slots_.size() - 1;
    for (const Slot& slot : old) {
      if (slot.number == k_none) continue;
      std::size_t place = hash_of(slot.index) & mask;
      while (slots_[place].number != k_none)
        place = (place + 1) & mask;
      slots_[place] = slot;
    }
  }

  std::vector<Slot> slots_;
  std::vector<Value> values_;
  GridIndex last_index_;  ///< what was asked for last
  std::uint32_t last_ = k_none;
};

}  // namespace sleight::physics
