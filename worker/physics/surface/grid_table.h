// A table of values by grid index. A value is computed when it is first accessed. Thread safety:
// none.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "worker/physics/broad_phase/flat_table.h"
#include "worker/physics/surface/surface_controls.h"

namespace sleight::physics {

/// References to values are valid until the next value is made.
template <class Value>
class GridTable {
 public:
  /// `room`: number of values for which memory is reserved.
  explicit GridTable(std::size_t room) : numbers_(room) { values_.reserve(room); }

  std::size_t size() const { return values_.size(); }

  /// Returns the value at an index; calls make(index) if there is none yet. REQUIRES: the index is
  /// not (INT32_MIN, INT32_MIN).
  template <class Make>
  const Value& at(GridIndex index, const Make& make) {
    const std::uint64_t key = key_of(index);
    if (key == last_key_) return values_[last_];
    if (const Slot* slot = numbers_.find(key)) {
      last_ = slot->number;
    } else {
      // make() may throw, so store the value first, then the slot that refers to it.
      Value made = make(index);
      values_.push_back(std::move(made));
      last_ = static_cast<std::uint32_t>(values_.size() - 1);
      numbers_.insert(key).first->number = last_;
    }
    last_key_ = key;
    return values_[last_];
  }

 private:
  struct Slot {
    std::uint64_t key = k_no_key;
    std::uint32_t number = 0;
  };
  static std::uint64_t key_of(GridIndex index) {
    const auto half = [](std::int32_t i) {
      return std::uint64_t{static_cast<std::uint32_t>(i) ^ 0x7fffffffU};
    };
    return half(index.i) << 32U | half(index.j);
  }

  FlatTable<Slot> numbers_;
  std::vector<Value> values_;
  std::uint64_t last_key_ = k_no_key;  ///< key of the last access
  std::uint32_t last_ = 0;
};

}  // namespace sleight::physics
