// JSON values. A JSON library reads and writes text. Only value.cpp includes the library, because
// it adds seconds to the compilation of a source.
//
// Invariants
//   1. An object keeps its keys in the order of their addition, and has each key once.
//   2. Integers are stored as std::uint64_t from 0, as std::int64_t below 0. Other numbers are
//      doubles.
//   3. Parsed values are nested at most k_depth_max levels deep.
//   4. Invalid UTF-8 is written as U+FFFD; NaN and infinities are written as null.
// Thread safety: a value type.
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

/// Maximum depth of parsed values. Deeper text is refused, because values are freed and written
/// recursively.
inline constexpr int k_depth_max = 200;

/// Thrown if a text is not JSON, or if a value has an unexpected kind.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Conversion;  // defined in value.cpp

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
  /// Creates an object if each element is a pair that begins with a text. Otherwise creates an
  /// array. So Value{{"a", 1}, {"b", 2}} is {"a": 1, "b": 2}.
  Value(std::initializer_list<Value> elements);
  /// Creates an object from a map, and an array from any other range.
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

  /// If the text is not JSON, throws Error that names the position.
  static Value parse(std::string_view text);
  /// Returns null if the text is not JSON.
  static Value parse_or_null(std::string_view text);

  /// Returns the value as text, on one line or with `indent` spaces per level. `is_ascii`: escapes
  /// all other characters.
  std::string dump(int indent = -1, bool is_ascii = false) const;

  bool is_null() const;
  bool is_boolean() const;
  bool is_number() const;
  bool is_whole() const;  ///< a non-negative integer
  bool is_string() const;
  bool is_array() const;
  bool is_object() const;

  /// Returns a bool, a number, a string, or a vector or map of these. Throws Error if the value has
  /// another kind, or if the value is an integer out of T's range.
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
  /// Throws Error if the value is not a string.
  const std::string& text() const;
  /// Throws Error if the value is not an array.
  const Array& elements() const;
  /// Throws Error if the value is not an object.
  const Object& items() const;

  /// Returns the number of elements or members; 0 for null, 1 for other values.
  std::size_t size() const;
  bool empty() const { return size() == 0; }

  /// Returns a key's value, or a null pointer if the key is missing or this is not an object.
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
  /// Returns the key's value; adds null if the key is missing. If this value is null, it becomes an
  /// object. Throws Error for other kinds.
  Value& operator[](std::string_view key);
  Value& operator[](const char* key) { return (*this)[std::string_view(key)]; }
  template <std::integral T>
  Value& operator[](T index) {
    return const_cast<Value&>(std::as_const(*this).at(static_cast<std::size_t>(index)));
  }
  /// Returns a key's value, or `otherwise` if the key is missing. Throws Error if the kind is
  /// wrong.
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

  /// If this value is null, it becomes an array. Throws Error for other kinds.
  void push_back(Value element);
  /// Removes a key if present.
  void erase(std::string_view key);
  void update(const Value& other);

  /// Compares numbers by value, and objects regardless of key order.
  friend bool operator==(const Value& a, const Value& b);
  /// Prints the value in test messages.
  friend std::ostream& operator<<(std::ostream& out, const Value& value);

 private:
  /// An integer or a bool. The header's templates pass it to value.cpp.
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
