// Lists the fields of a segment. Three formats use this list: the columns of motions in an archive,
// the motions cached beside a run's store, and the columns that the gallery's page reads.
//
// A field added to this list is written and read in all three formats. The archive's checker has
// its own list (common/archive/structure.cpp), so that an error here can't hide there.
//
// Thread safety: constants and pure functions.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <limits>
#include <optional>
#include <tuple>
#include <type_traits>
#include <utility>

#include "common/motion/segment.h"

namespace sleight::motion {

template <class Record, class Value>
struct Field {
  const char* name;  ///< name of the column
  Value Record::*member;
  const char* meaning;  ///< one sentence
  const char* unit = "1";
};
/// Before version 17, clang needs this deduction guide.
template <class Record, class Value>
Field(const char*, Value Record::*, const char*, const char* = "1") -> Field<Record, Value>;

/// The fields in the order of the archive's columns. The descriptions of `mode` and `cause` say
/// what each number means.
inline constexpr std::tuple k_fields{
    Field{"body", &Segment::body, "feature of /scene that moves"},
    Field{"start_s", &Segment::start_s, "time at which the segment begins", "s"},
    Field{"mode", &Segment::mode, "0 flying, 1 sliding, 2 rolling, 3 resting"},
    Field{"cause", &Segment::cause,
          "event that began the segment: 0 the body entered, 1 it hit the partner, 2 its mode "
          "changed, 3 it came to rest or woke"},
    Field{"partner", &Segment::partner, "feature of /scene that the body hit; -1 if none"},
    Field{"position_m", &Segment::position_m, "centre at the start of the segment", "m"},
    Field{"velocity_mps", &Segment::velocity_mps,
          "velocity of the centre at the start of the segment", "m s-1"},
    Field{"acceleration_mps2", &Segment::acceleration_mps2, "constant acceleration of the centre",
          "m s-2"},
    Field{"orientation", &Segment::orientation,
          "rotation from the body's frame to the scene's, at the start of the segment"},
    Field{"angular_velocity_radps", &Segment::angular_velocity_radps,
          "angular velocity in the scene's frame, at the start of the segment", "rad s-1"},
    Field{"angular_acceleration_radps2", &Segment::angular_acceleration_radps2,
          "constant angular acceleration in the scene's frame", "rad s-2"}};

template <class Fields, class Act>
constexpr void for_each_field(const Fields& fields, Act act) {
  std::apply([&](const auto&... each) { (act(each), ...); }, fields);
}

/// Returns the numbers of a value. A vector has three numbers (x, y, z), a rotation has four (w, x,
/// y, z), and any other value has one.
template <std::integral Value>
constexpr std::array<Value, 1> elements_of(Value value) {
  return {value};
}
template <class Value>
requires std::is_enum_v<Value>
constexpr std::array<std::underlying_type_t<Value>, 1> elements_of(Value value) {
  return {static_cast<std::underlying_type_t<Value>>(value)};
}
inline std::array<double, 1> elements_of(double value) {
  return {value};
}
inline std::array<double, 3> elements_of(const math::Vec3& value) {
  return {value.x(), value.y(), value.z()};
}
inline std::array<double, 4> elements_of(const math::Quat& value) {
  return {value.w(), value.x(), value.y(), value.z()};
}
template <class Value>
using Elements = decltype(elements_of(std::declval<const Value&>()));
template <class Value>
using Element = typename Elements<Value>::value_type;
template <class Value>
inline constexpr std::size_t k_width = std::tuple_size_v<Elements<Value>>;

inline constexpr std::size_t k_elements = std::apply(
    []<class... Values>(const Field<Segment, Values>&...) { return (k_width<Values> + ...); },
    k_fields);

/// Maximum of an integer field. REQUIRES: a specialisation for each enumeration.
template <class Value>
inline constexpr auto k_last = std::numeric_limits<Value>::max();
template <>
inline constexpr std::size_t k_last<Mode> = k_mode_names.size() - 1;
template <>
inline constexpr std::size_t k_last<Cause> = k_cause_names.size() - 1;

/// The reverse of elements_of. Returns nothing if a number is out of range. REQUIRES:
/// k_width<Value> numbers.
template <class Value, class Number>
std::optional<Value> value_of(const Number* numbers) {
  if constexpr (std::same_as<Value, math::Vec3>) {
    return Value(numbers[0], numbers[1], numbers[2]);
  } else if constexpr (std::same_as<Value, math::Quat>) {
    return Value(numbers[0], numbers[1], numbers[2], numbers[3]);
  } else if constexpr (std::same_as<Value, double>) {
    return *numbers;
  } else {
    const auto number = static_cast<double>(*numbers);
    const bool is_in_range =
        number >= static_cast<double>(std::numeric_limits<Element<Value>>::lowest()) &&
        number <= static_cast<double>(k_last<Value>);
    if (!is_in_range) return std::nullopt;
    return static_cast<Value>(*numbers);
  }
}

}  // namespace sleight::motion
