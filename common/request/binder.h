// Declares each key of a section once. Reading, normalising and help all use this declaration.
//
// A bind function names each key of a section once:
//
//   void bind_world(Binder& world, WorldParameters& p) {
//     world.number("restitution", p.restitution,
//                  {.minimum = 0, .above_minimum = true, .maximum = 1,
//                   .help = "coefficient of restitution, along the normal"});
//   }
//
// If the binder has a section of a file, declaring a key reads the key: its value is stored in the
// member, an error in the diagnostics. Without a section, the member doesn't change. In both cases
// keys() then describes the keys, in order of declaration. The description is for help; it includes
// the current value, for the normalised text.
//
// A key's value is a number, a boolean, a string, an array of them, a table `[section.key]` or any
// number of tables `[[section.key]]`. Tables have binders of their own, and may nest:
//
//   world.tables("body", p.bodies, {.count_max = 9}, [](Binder& body, Body& b) {
//     body.numbers("at_mm", b.at_mm, {.unit = "mm"});            // at_mm = [0, 0, 400]
//     b.is_ring = body.table("ring", b.ring, "copies", &bind_ring);  // [world.body.ring]
//     body.tables("part", b.parts, {.count_max = 9}, &bind_part);    // [[world.body.part]]
//   });
//
// Invariants
//   1. A member's value before the call is the key's default. If the file has no valid value for
//      the key, the member keeps its default. So if its default is in range, the member is in range
//      after the call.
//   2. Defaults do not depend on other keys, and a bind function declares the same keys every time.
//   3. If there were no errors, writing bound() as TOML and reading the text again gives the same
//      members and the same bound().
// Errors in the file become diagnostics with places as in diagnostic.h. A default out of range, or
// a key that is declared twice, is a bug and aborts the process. Not thread-safe.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "common/request/diagnostic.h"
#include "common/request/document.h"

namespace sleight::request {

/// Whether a file may omit the key.
enum class Presence {
  defaulted,  ///< optional in a file, with a default
  optional,   ///< optional without a default; omitted in the normalised text
  required,   ///< a file must give the key
};

/// A key's description for people.
struct KeySpec {
  std::string key = {};
  std::string unit = {};      ///< "D", "m/s2", "degrees"; empty for a pure number
  std::string range = {};     ///< such as "(0, 1]", "1 .. 64", "true or false", "a | b"
  std::string expected = {};  ///< text after "expected", such as "a number above 0 and at most 1"
  std::string fallback = {};  ///< default as TOML; empty unless `defaulted`
  Presence presence = Presence::defaulted;
  std::string help = {};  ///< one line
};

struct BoundKey {
  KeySpec spec;
  std::string value;  ///< as TOML; empty if an optional or required key is not given
};

struct BoundTables;

/// A section's or table's keys and tables, in order of declaration.
struct BoundSection {
  std::vector<BoundKey> keys;
  std::vector<BoundTables> tables;  ///< `keys` has their keys too, without a value
};

struct BoundTables {
  std::string key;
  std::string name;        ///< between the header's brackets: "section.key" or "[section.key]"
  BoundSection described;  ///< each table's keys, with their defaults
  std::vector<BoundSection> tables;  ///< the tables in the file; of `[section.key]` at most one
};

/// A finite number. A file may also give an integer. -0 is read as 0.
struct NumberOptions {
  double minimum = std::numeric_limits<double>::lowest();
  bool above_minimum = false;  ///< the minimum is excluded
  double maximum = std::numeric_limits<double>::max();
  bool below_maximum = false;
  std::string_view unit = "";
  std::string_view help = "";
};

struct IntegerOptions {
  std::int64_t minimum = std::numeric_limits<std::int64_t>::min();
  std::int64_t maximum = std::numeric_limits<std::int64_t>::max();
  std::string_view unit = "";
  std::string_view help = "";
};

struct TextOptions {
  std::size_t characters_max = 256;
  std::string_view help = "";
};

/// The number of an array's elements, and whether a file must give the array.
struct ListOptions {
  std::size_t count_min = 1;
  std::size_t count_max = 1;
  bool required = false;
};

/// Maximum numbers in an array and its rows. About as many fill a file of k_request_bytes_max.
inline constexpr std::size_t k_array_numbers_max = 60'000;

struct TablesOptions {
  std::size_t count_max = 1;
  std::string_view help = "";
};

/// A choice that a key allows: its name in the file and its value.
template <class T>
struct Named {
  std::string_view name;
  T value;
};

class Binder {
 public:
  /// Reads `section`. If `section` is null, nothing is read, and keys() lists the defaults.
  /// `section` and `diagnostics` are borrowed.
  Binder(std::string section_name, const Section* section, Diagnostics& diagnostics);

  void number(std::string_view key, double& value, const NumberOptions& options);

  /// An angle. The file and `options` give degrees; `value_rad` is in radians. The normalised text
  /// repeats the given degrees, because converting them back from radians could change digits.
  void angle_deg(std::string_view key, double& value_rad, const NumberOptions& options);

  /// A length. The file and `options` give millimetres; `value_m` is in metres.
  void length_mm(std::string_view key, double& value_m, NumberOptions options);

  /// Shares, which must add up to 1. An error of the sum is at the first key.
  struct Share {
    const char* key;
    double& value;
    const char* help;
  };
  void shares(std::initializer_list<Share> all);

  /// An optional number. Like all functions named optional_... and required_..., returns whether
  /// the file has a valid value; if not, `value` is unchanged. T is double or an optional of it.
  template <class T>
  bool optional_number(std::string_view key, T& value, const NumberOptions& options) {
    return assign(read<double>(key, std::nullopt, Presence::optional, options), value);
  }

  /// A number that the file must have.
  bool required_number(std::string_view key, double& value, const NumberOptions& options) {
    return assign(read<double>(key, std::nullopt, Presence::required, options), value);
  }

  /// An array of numbers, such as a position: a std::array or a vector of fixed size. `each`
  /// describes every number.
  template <class Vector>
  void numbers(std::string_view key, Vector& value, const NumberOptions& each) {
    const std::vector<double> fallback(value.begin(), value.end());
    std::ranges::copy(*read_array<double>(key, row_of(value), &fallback, false, each),
                      value.begin());
  }

  /// An optional array of numbers.
  template <class Vector>
  bool optional_numbers(std::string_view key, Vector& value, const NumberOptions& each) {
    const auto given = read_array<double>(key, row_of(value), nullptr, false, each);
    if (given) std::ranges::copy(*given, value.begin());
    return given.has_value();
  }

  /// An array of numbers. If the file has no valid one, `values` stays empty. REQUIRES: `values` is
  /// empty; count_max <= k_array_numbers_max.
  void numbers(std::string_view key, std::vector<double>& values, const ListOptions& list,
               const NumberOptions& each);

  /// An array of rows, each an array of N numbers: `[[0, 0, 1], [1, 0, 0]]`. T is double or
  /// integral. `each` describes every number. If the file has no valid one, `rows` stays empty.
  /// REQUIRES: `rows` is empty; N * count_max <= k_array_numbers_max; the range fits T.
  template <class T, std::size_t N>
  void rows(std::string_view key, std::vector<std::array<T, N>>& rows, const ListOptions& list,
            const std::conditional_t<std::is_integral_v<T>, IntegerOptions, NumberOptions>& each) {
    if constexpr (std::is_integral_v<T>) check_fits<T>(each);
    using Element = std::conditional_t<std::is_integral_v<T>, std::int64_t, double>;
    CHECK(rows.empty());
    const Shape shape{list.count_min, list.count_max, N, true};
    const auto given = read_array<Element>(key, shape, nullptr, list.required, each);
    for (std::size_t i = 0; given && i < given->size(); ++i) {
      if (i % N == 0) rows.emplace_back();
      rows.back()[i % N] = static_cast<T>((*given)[i]);
    }
  }

  /// An array of texts. If the file has no valid one, `values` stays empty. REQUIRES: `values` is
  /// empty; count_max <= k_array_numbers_max.
  void texts(std::string_view key, std::vector<std::string>& values, const ListOptions& list,
             const TextOptions& each);

  /// REQUIRES: the range fits T.
  template <class T>
  requires std::is_integral_v<T>
  void integer(std::string_view key, T& value, const IntegerOptions& options) {
    check_fits<T>(options);
    value = static_cast<T>(
        *read<std::int64_t>(key, static_cast<std::int64_t>(value), Presence::defaulted, options));
  }

  /// An optional integer. REQUIRES: the range fits T.
  template <class T>
  bool optional_integer(std::string_view key, std::optional<T>& value,
                        const IntegerOptions& options) {
    check_fits<T>(options);
    const auto given = read<std::int64_t>(key, std::nullopt, Presence::optional, options);
    if (given) value = static_cast<T>(*given);
    return given.has_value();
  }

  void boolean(std::string_view key, bool& value, std::string_view help);

  /// A UTF-8 text of at most options.characters_max characters (code points).
  void text(std::string_view key, std::string& value, const TextOptions& options);

  /// An optional text. T is std::string or an optional of it.
  template <class T>
  bool optional_text(std::string_view key, T& value, const TextOptions& options) {
    return assign(read<std::string>(key, std::nullopt, Presence::optional, options), value);
  }

  /// A text that the file must have.
  bool required_text(std::string_view key, std::string& value, const TextOptions& options) {
    return assign(read<std::string>(key, std::nullopt, Presence::required, options), value);
  }

  /// One of `choices` by name. REQUIRES: `value` is among them.
  template <class T>
  void choice(std::string_view key, T& value, std::span<const Named<T>> choices,
              std::string_view help) {
    std::size_t now = 0;
    while (now < choices.size() && !(choices[now].value == value))
      ++now;
    CHECK_LT(now, choices.size());
    value = choices[*read_choice(key, now, names_of(choices), help)].value;
  }

  /// Like choice(), but the file must have the key.
  template <class T>
  bool required_choice(std::string_view key, T& value, std::span<const Named<T>> choices,
                       std::string_view help) {
    const auto chosen = read_choice(key, std::nullopt, names_of(choices), help);
    if (chosen) value = choices[*chosen].value;
    return chosen.has_value();
  }

  /// `[[section.key]]`: any number of tables. Each table gives an element of `values`. `bind`
  /// declares the keys of one table, which may again be tables. For help, `bind` is also called
  /// once without a section, for a default-constructed T; errors are then ignored. If there are too
  /// many tables, an error is added and no table is read.
  template <class T>
  void tables(std::string_view key, std::vector<T>& values, const TablesOptions& options,
              const std::type_identity_t<std::function<void(Binder& table, T& value)>>& bind) {
    values.clear();
    BoundTables bound = named_tables(key, true);
    const std::vector<const Section*> given = declare_tables(bound, options);
    T described{};
    bound.described = bind_table(bound, nullptr, described, bind);
    for (const Section* table : given)
      bound.tables.push_back(bind_table(bound, table, values.emplace_back(), bind));
    bound_.tables.push_back(std::move(bound));
  }

  /// `[section.key]` or `key = {...}`: an optional table. Returns whether the file has it. `bind`
  /// declares the table's keys, which may again be tables. If the file omits a key, its member
  /// keeps its default. For help, `bind` is also called without a section, for a copy of `value`.
  /// The normalised text has the table only if the file has it.
  template <class T>
  bool table(std::string_view key, T& value, std::string_view help,
             const std::type_identity_t<std::function<void(Binder& table, T& value)>>& bind) {
    BoundTables bound = named_tables(key, false);
    const Section* given = declare_table(bound, help);
    T described = value;
    bound.described = bind_table(bound, nullptr, described, bind);
    if (given != nullptr) bound.tables.push_back(bind_table(bound, given, value, bind));
    bound_.tables.push_back(std::move(bound));
    return given != nullptr;
  }

  /// Sets the value that the normalised text shows for a key. For keys that the file omits, and
  /// whose value follows from other keys. Empty: the key is omitted. REQUIRES: the key is declared.
  void settle(std::string_view key, std::string value);

  /// Returns whether the file has the key, with a valid value or not.
  bool given(std::string_view key) const;

  /// Returns whether the key is declared and its value has no error. Checks of several keys call
  /// valid() first, so that an error is not reported twice.
  bool valid(std::string_view key) const;
  bool all_valid(std::initializer_list<std::string_view> keys) const {
    return std::ranges::all_of(keys, [this](std::string_view key) { return valid(key); });
  }

  /// Adds an error: this key conflicts with others. The error's place is the key. If the file omits
  /// the key, the place is the section. In the text, `message` follows `'key' in [section]`.
  void error(std::string_view key, std::string_view message);

  /// Returns whether all keys read so far are free of errors.
  bool is_sound() const { return invalid_.empty(); }

  /// Returns the line at which the section or table begins. 0: it is not in a file.
  std::uint32_t line() const { return section_ == nullptr ? 0 : section_->place.line; }

  const std::string& section_name() const { return section_name_; }
  const BoundSection& bound() const { return bound_; }
  const std::vector<BoundKey>& keys() const { return bound_.keys; }

 private:
  template <class T>
  static void check_fits(const IntegerOptions& options) {
    CHECK(std::in_range<T>(options.minimum) && std::in_range<T>(options.maximum));
  }
  template <class T>
  static std::vector<std::string> names_of(std::span<const Named<T>> choices) {
    std::vector<std::string> names;
    for (const auto& choice : choices)
      names.emplace_back(choice.name);
    return names;
  }

  /// An array of `columns` elements; or, if `is_rows`, an array of such arrays. A list has rows of
  /// one element that aren't arrays.
  struct Shape {
    std::size_t rows_min = 1;
    std::size_t rows_max = 1;
    std::size_t columns = 1;
    bool is_rows = false;
  };
  static Shape row_of(const auto& numbers) {
    const auto count = static_cast<std::size_t>(numbers.size());
    return {.rows_min = count, .rows_max = count};
  }
  struct ExpectedElements;
  /// Returns whether all elements are valid.
  template <class Element, class Options>
  bool read_elements(const Value& value, const Shape& shape, const ExpectedElements& expected,
                     const Options& each, std::vector<Element>& found);
  /// Returns the elements of all rows. Instantiated for double, std::int64_t and std::string.
  template <class Element, class Options>
  std::optional<std::vector<Element>> read_array(std::string_view key, const Shape& shape,
                                                 const std::vector<Element>* fallback,
                                                 bool required, const Options& each);
  /// Without a section, describes the table and ignores errors.
  template <class T>
  BoundSection bind_table(const BoundTables& tables, const Section* section, T& value,
                          const std::function<void(Binder& table, T& value)>& bind) {
    Diagnostics ignored("");
    Binder table(tables.name, section, section == nullptr ? ignored : diagnostics_);
    bind(table, value);
    if (section != nullptr && !table.is_sound()) invalid_.push_back(tables.key);
    return std::move(table.bound_);
  }

  /// Instantiated for double, std::int64_t and std::string.
  template <class Element, class Options>
  std::optional<Element> read(std::string_view key, std::optional<Element> fallback,
                              Presence presence, const Options& options);
  template <class Element, class T>
  static bool assign(const std::optional<Element>& given, T& value) {
    if (given) value = *given;
    return given.has_value();
  }
  /// Without a fallback, the file must have the key.
  std::optional<std::size_t> read_choice(std::string_view key, std::optional<std::size_t> fallback,
                                         const std::vector<std::string>& names,
                                         std::string_view help);

  /// Adds the key and returns its value in the file, or null if the file omits the key.
  const Value* declare(KeySpec spec);
  BoundTables named_tables(std::string_view key, bool is_array) const;
  /// Returns no tables if the file has too many.
  std::vector<const Section*> declare_tables(const BoundTables& tables,
                                             const TablesOptions& options);
  const Section* declare_table(const BoundTables& table, std::string_view help);
  void refuse(const Value& value, std::string_view hint = "");
  void fail(std::string_view key, Place place, std::string_view message);

  std::string section_name_;
  const Section* section_;
  Diagnostics& diagnostics_;
  BoundSection bound_;
  std::vector<std::string> invalid_;
};

}  // namespace sleight::request
