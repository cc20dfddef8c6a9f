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
// Invariants
//   1. A member's value before the call is the key's default. If the file has no valid value for
//      the key, the member keeps its default. So if its default is in range, the member is in range
//      after the call.
//   2. Defaults do not depend on other keys, and a bind function declares the same keys every time.
//   3. If there were no errors, writing keys() as TOML and reading the text again gives the same
//      members and the same keys().
// Errors in the file become diagnostics with places as in diagnostic.h. A default out of range, or
// a key that is declared twice, is a bug and aborts the process. Not thread-safe.
#pragma once

#include <cstdint>
#include <functional>
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

struct BoundTables {
  std::string key;
  std::string name;             ///< "[section.key]": the text between the brackets of the section
  std::vector<BoundKey> specs;  ///< description of each table's keys, with their defaults
  std::vector<std::vector<BoundKey>> tables;  ///< the tables in the file
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

  /// An optional number. REQUIRES: `value` is empty.
  void optional_number(std::string_view key, std::optional<double>& value,
                       const NumberOptions& options);

  /// REQUIRES: the range fits T.
  template <class T>
  requires std::is_integral_v<T>
  void integer(std::string_view key, T& value, const IntegerOptions& options) {
    check_fits<T>(options);
    value = static_cast<T>(
        *read_integer(key, static_cast<std::int64_t>(value), Presence::defaulted, options));
  }

  /// An optional integer. REQUIRES: `value` is empty; the range fits T.
  template <class T>
  requires std::is_integral_v<T>
  void optional_integer(std::string_view key, std::optional<T>& value,
                        const IntegerOptions& options) {
    check_fits<T>(options);
    CHECK(!value.has_value());
    const auto given = read_integer(key, std::nullopt, Presence::optional, options);
    if (given) value = static_cast<T>(*given);
  }

  void boolean(std::string_view key, bool& value, std::string_view help);

  /// A UTF-8 text of at most options.characters_max characters (code points).
  void text(std::string_view key, std::string& value, const TextOptions& options);

  /// One of `choices` by name. REQUIRES: `value` is among them.
  template <class T>
  void choice(std::string_view key, T& value, std::span<const Named<T>> choices,
              std::string_view help) {
    std::size_t now = 0;
    while (now < choices.size() && !(choices[now].value == value))
      ++now;
    CHECK_LT(now, choices.size());
    value = choices[*read_choice(key, now, names_of(choices), Presence::defaulted, help)].value;
  }

  /// Like choice(), but the file must have the key. If the file omits the key, `value` is
  /// unchanged.
  template <class T>
  void required_choice(std::string_view key, T& value, std::span<const Named<T>> choices,
                       std::string_view help) {
    const auto chosen = read_choice(key, std::nullopt, names_of(choices), Presence::required, help);
    if (chosen) value = choices[*chosen].value;
  }

  /// `[[section.key]]`: any number of tables. Each table gives an element of `values`. `bind`
  /// declares the keys of one table. For help, `bind` is also called once for a default-constructed
  /// T. If there are too many tables, an error is added and no table is read.
  template <class T>
  void tables(std::string_view key, std::vector<T>& values, const TablesOptions& options,
              const std::function<void(Binder& table, T& value)>& bind) {
    values.clear();
    const TableArray* given = declare_tables(key, options);
    const std::string name = arrays_.back().name;
    T described{};
    Binder help(name, nullptr, diagnostics_);
    bind(help, described);
    arrays_.back().specs = help.keys();
    for (std::size_t i = 0; given != nullptr && i < given->tables.size(); ++i) {
      Binder table(name, &given->tables[i], diagnostics_);
      bind(table, values.emplace_back());
      arrays_.back().tables.push_back(table.keys());
    }
  }

  /// Sets the value that the normalised text shows for a key. For keys that the file omits, and
  /// whose value follows from other keys. Empty: the key is omitted. REQUIRES: the key is declared.
  void settle(std::string_view key, std::string value);

  /// Returns whether the file has the key, with a valid value or not.
  bool given(std::string_view key) const;

  /// Returns whether the key is declared and its value has no error. Checks of several keys call
  /// valid() first, so that an error is not reported twice.
  bool valid(std::string_view key) const;

  /// Adds an error: this key conflicts with others. The error's place is the key. If the file omits
  /// the key, the place is the section. In the text, `message` follows `'key' in [section]`.
  void error(std::string_view key, std::string_view message);

  /// Returns whether all keys read so far are free of errors.
  bool is_sound() const { return invalid_.empty(); }

  /// Returns the line at which the section or table begins. 0: it is not in a file.
  std::uint32_t line() const { return section_ == nullptr ? 0 : section_->place.line; }

  const std::string& section_name() const { return section_name_; }
  const std::vector<BoundKey>& keys() const { return keys_; }
  const std::vector<BoundTables>& arrays() const { return arrays_; }

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

  std::optional<double> read_number(std::string_view key, std::optional<double> fallback,
                                    const NumberOptions& options);
  std::optional<std::int64_t> read_integer(std::string_view key,
                                           std::optional<std::int64_t> fallback, Presence presence,
                                           const IntegerOptions& options);
  std::optional<std::size_t> read_choice(std::string_view key, std::optional<std::size_t> fallback,
                                         const std::vector<std::string>& names, Presence presence,
                                         std::string_view help);

  /// Adds the key and returns its value in the file, or null if the file omits the key.
  const Value* declare(KeySpec spec);
  /// Returns null if the file has no tables, or too many tables.
  const TableArray* declare_tables(std::string_view key, const TablesOptions& options);
  void refuse(const Value& value, std::string_view hint = "");
  void fail(std::string_view key, Place place, std::string_view message);

  std::string section_name_;
  const Section* section_;
  Diagnostics& diagnostics_;
  std::vector<BoundKey> keys_;
  std::vector<BoundTables> arrays_;
  std::vector<std::string> invalid_;
};

}  // namespace sleight::request
