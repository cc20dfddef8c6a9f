// A value, or the reason for its absence. A Result is for expected failures, not for bugs.
#pragma once

#include <utility>
#include <variant>

#include "common/base/check.h"

namespace sleight::base {

/// Holds a T or an E. Reading the absent part is a bug and aborts the process.
template <class T, class E>
class [[nodiscard]] Result {
 public:
  Result(T value) : held_(std::in_place_index<0>, std::move(value)) {}
  Result(E error) : held_(std::in_place_index<1>, std::move(error)) {}

  bool ok() const { return held_.index() == 0; }
  explicit operator bool() const { return ok(); }

  const T& value() const& { return held<0>(); }
  T&& value() && {
    CHECK(ok());
    return std::get<0>(std::move(held_));
  }
  const E& error() const { return held<1>(); }

 private:
  template <std::size_t index>
  const auto& held() const {
    CHECK_EQ(held_.index(), index);
    return std::get<index>(held_);
  }
  std::variant<T, E> held_;
};

}  // namespace sleight::base
