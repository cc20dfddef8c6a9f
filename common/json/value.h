// JSON values. This header is small on purpose: the JSON library that reads and writes the text is
// included by value.cpp alone, since each source that includes it takes seconds longer to compile.
//
// Invariants
//   1. An object keeps the order in which its keys were added; a key stands in it once.
//   2. A whole number is an std::uint64_t from 0 on, an std::int64_t below 0; all others are
//   doubles.
//   3. Parsed values are nested at most k_depth_max deep.
//   4. Text that is not UTF-8 is written with U+FFFD in place of what is wrong; NaN and infinities
//      are written as null.
// A value type; thread-safe as such.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iosfwd>
#include <ranges>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace sleight::json {

/// Deeper text is refused: values are freed and written recursively.
inline constexpr int k_depth_max = 200;

/// A text is not JSON, or a value is not what its reader expected.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Conversion;  // the source's

template <class T>
concept is_map = requires {
  typename T::mapped_type;
};

class Value {
 public:
  struct Member;
  using Array = std::vector<Value>;
  using Object = std::vector<Member>;

  Value();  ///< null
  Value(std::nullptr_t);
  template <std::same_as<bool> Bool>
  Value(Bool value) : Value(Whole{.flag = value, .is_flag = true}) {}
  template <std::integral T>
  requires(!std::same_as<T, bool>) Value(T value)
      : Value(Whole{.bits = static_cast<std::uint64_t>(value), .is_negative = value < T(0)}) {}
  Value(double value);
  Value(const char* text);
  Value(std::string_view text);
  Value(std::string text);
  /// An object if each element is an array of two whose first is a text, else an array: so
  /// Value{{"a", 1}, {"b", 2}} is {"a": 1, "b": 2}.
  Value(std::initializer_list<Value> elements);
  /// An array of a range's elements; of a map an object.
  template <std::ranges::input_range Range>
  requires(!std::convertible_to<const Range&, std::string_view> &&
           !std::same_as<std::remove_cvref_t<Range>, Value>) Value(const Range& range)
      : Value(is_map<Range> ? object() : array()) {
    for (const auto& element : range) {
      if constexpr (is_map<Range>) {
        (*this)[element.first] = Value(element.second);
      } else {
        push_back(Value(element));
      }
    }
  }
  Value(const Value& other);
  Value(Value&& other) noexcept;
  Value& operator=(const Value& other);
  Value& operator=(Value&& other) noexcept;
  ~Value();

  static Value array();
  static Value array(std::initializer_list<Value> elements);
  static Value object();

  /// Throws Error, with the place in the text.
  static Value parse(std::string_view text);
  /// Null where the text is not JSON.
  static Value parse_or_null(std::string_view text);

  /// The text of this value: on one line, or `indent` spaces per level. `is_ascii`: all else is
  /// escaped.
  std::string dump(int indent = -1, bool is_ascii = false) const;

  bool is_null() const;
  bool is_boolean() const;
  bool is_number() const;
  bool is_whole() const;  ///< a whole number that is not negative
  bool is_string() const;
  bool is_array() const;
  bool is_object() const;

  /// The value as a bool, a number, a string, or a vector or map of these. Throws Error if it is of
  /// another kind, or a whole number that T does not hold.
  template <class T>
  T get() const {
    if constexpr (std::same_as<T, bool>) {
      return flag();
    } else if constexpr (std::integral<T>) {
      const Whole read = whole();
      const T value = static_cast<T>(read.bits);
      if ((value < T(0)) != read.is_negative || static_cast<std::uint64_t>(value) != read.bits)
        refuse("an integer in the expected range");
      return value;
    } else if constexpr (std::floating_point<T>) {
      return static_cast<T>(number());
    } else if constexpr (std::same_as<T, std::string>) {
      return text();
    } else if constexpr (is_map<T>) {
      T values;
      for (const auto& key : keys())
        values[key] = at(key).get<typename T::mapped_type>();
      return values;
    } else {
      T values;
      for (const Value& element : elements())
        values.push_back(element.get<typename T::value_type>());
      return values;
    }
  }
  /// Throws Error if it is no string.
  const std::string& text() const;
  /// Throws Error if it is no array.
  const Array& elements() const;
  /// Throws Error if it is no object.
  const Object& items() const;

  /// Elements of an array, members of an object, 0 of null, 1 of all else.
  std::size_t size() const;
  bool empty() const { return size() == 0; }

  /// The value of a key; null pointer where it is missing or this is no object.
  const Value* find(std::string_view key) const;
  bool contains(std::string_view key) const { return find(key) != nullptr; }
  /// Throws Error if the key or the element is missing.
  const Value& at(std::string_view key) const;
  const Value& at(std::size_t index) const;
  const Value& operator[](std::string_view key) const { return at(key); }
  const Value& operator[](const char* key) const { return at(key); }
  template <std::integral T>
  const Value& operator[](T index) const {
    return at(static_cast<std::size_t>(index));
  }
  /// Adds null under a key that is missing. Null becomes an object; throws Error for other kinds.
  Value& operator[](std::string_view key);
  Value& operator[](const char* key) { return (*this)[std::string_view(key)]; }
  template <std::integral T>
  Value& operator[](T index) {
    return const_cast<Value&>(std::as_const(*this).at(static_cast<std::size_t>(index)));
  }
  /// The value of a key, or `otherwise` where it is missing. Throws Error if it is of another kind.
  template <class T>
  T value(std::string_view key, T otherwise) const {
    const Value* found = find(key);
    if constexpr (std::same_as<T, Value>) {
      return found ? *found : otherwise;
    } else {
      return found ? found->get<T>() : otherwise;
    }
  }
  std::string value(std::string_view key, const char* otherwise) const;

  /// Null becomes an array; throws Error for other kinds.
  void push_back(Value element);
  /// Takes a key away, if it is there.
  void erase(std::string_view key);
  /// Sets each of another object's keys.
  void update(const Value& other);

  /// Numbers are equal by value; objects whatever the order of their keys.
  friend bool operator==(const Value& a, const Value& b);
  /// As a test's message shows it.
  friend std::ostream& operator<<(std::ostream& out, const Value& value);

 private:
  /// What the header's templates hand to the source.
  struct Whole {
    std::uint64_t bits = 0;
    bool is_negative = false;
    bool flag = false;
    bool is_flag = false;
  };
  Value(Whole whole);
  bool flag() const;
  Whole whole() const;
  double number() const;
  std::vector<std::string> keys() const;
  [[noreturn]] void refuse(const char* expected) const;
  friend struct Conversion;

  std::variant<std::nullptr_t, bool, std::int64_t, std::uint64_t, double, std::string, Array,
               Object>
      value_;
};

struct Value::Member {
  std::string key;
  Value value;

  friend bool operator==(const Member&, const Member&) = default;
};

}  // namespace sleight::json
