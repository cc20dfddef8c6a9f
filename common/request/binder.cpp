#include "common/request/binder.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "common/request/nearest.h"
#include "common/request/text.h"

namespace sleight::request {
namespace {

std::string with_unit(std::string words, std::string_view unit) {
  return unit.empty() ? words : fmt::format("{} {}", words, unit);
}

/// Describes a range as "an integer from 1 to 64", and as "1 .. 64" for the table of keys.
void describe_range(const IntegerOptions& options, KeySpec& spec) {
  spec.range = fmt::format("{} .. {}", options.minimum, options.maximum);
  spec.expected = with_unit(
      fmt::format("an integer from {} to {}", options.minimum, options.maximum), options.unit);
}

/// Describes a range as "a number above 0 and at most 1", and as "(0, 1]" for the table of keys.
void describe_range(const NumberOptions& options, KeySpec& spec) {
  const bool has_minimum = options.minimum != NumberOptions{}.minimum;
  const bool has_maximum = options.maximum != NumberOptions{}.maximum;
  const std::string minimum = plain_number(options.minimum);
  const std::string maximum = plain_number(options.maximum);
  spec.range = fmt::format("{}{}, {}{}", !has_minimum || options.above_minimum ? "(" : "[",
                           has_minimum ? minimum : "-inf", has_maximum ? maximum : "inf",
                           !has_maximum || options.below_maximum ? ")" : "]");

  std::string words = "a number";
  if (has_minimum && has_maximum && !options.above_minimum && !options.below_maximum) {
    words += fmt::format(" from {} to {}", minimum, maximum);
  } else {
    if (has_minimum) words += (options.above_minimum ? " above " : " of at least ") + minimum;
    if (has_minimum && has_maximum) words += " and";
    if (has_maximum) words += (options.below_maximum ? " below " : " at most ") + maximum;
    if (!has_minimum && !has_maximum) words = "a finite number";
  }
  spec.expected = with_unit(words, options.unit);
}

bool in_range(double number, const NumberOptions& options) {
  return std::isfinite(number) &&
         (options.above_minimum ? number > options.minimum : number >= options.minimum) &&
         (options.below_maximum ? number < options.maximum : number <= options.maximum);
}

}  // namespace

Binder::Binder(std::string section_name, const Section* section, Diagnostics& diagnostics)
    : section_name_(std::move(section_name)), section_(section), diagnostics_(diagnostics) {}

const Value* Binder::declare(KeySpec spec) {
  for (const BoundKey& bound : keys_)
    CHECK_NE(bound.spec.key, spec.key);
  const Entry* entry = section_ == nullptr ? nullptr : section_->find(spec.key);
  if (entry == nullptr && section_ != nullptr && spec.presence == Presence::required) {
    fail(spec.key, section_->place, fmt::format("missing; expected {}", spec.expected));
  }
  keys_.push_back({std::move(spec), ""});
  return entry == nullptr ? nullptr : &entry->value;
}

void Binder::fail(std::string_view key, Place place, std::string_view message) {
  invalid_.emplace_back(key);
  diagnostics_.add(place, fmt::format("'{}' in [{}]: {}", key, section_name_, message));
}

void Binder::refuse(const Value& value, std::string_view hint) {
  const KeySpec& spec = keys_.back().spec;
  fail(spec.key, value.place,
       fmt::format("expected {}, found {}{}", spec.expected, description(value), hint));
}

std::optional<double> Binder::read_number(std::string_view key, std::optional<double> fallback,
                                          const NumberOptions& options) {
  KeySpec spec{.key = std::string(key),
               .unit = std::string(options.unit),
               .presence = fallback ? Presence::defaulted : Presence::optional,
               .help = std::string(options.help)};
  if (fallback) {
    CHECK(in_range(*fallback, options));
    spec.fallback = toml_number(*fallback);
  }
  describe_range(options, spec);

  std::optional<double> number = fallback;
  if (const Value* value = declare(std::move(spec))) {
    double found = std::numeric_limits<double>::quiet_NaN();
    if (const auto* as_number = std::get_if<double>(&value->held)) found = *as_number;
    if (const auto* as_integer = std::get_if<std::int64_t>(&value->held)) {
      found = static_cast<double>(*as_integer);
    }
    if (in_range(found, options)) {
      number = found + 0.0;  // -0 becomes 0
    } else {
      refuse(*value);
    }
  }
  if (number) keys_.back().value = toml_number(*number);
  return number;
}

void Binder::number(std::string_view key, double& value, const NumberOptions& options) {
  value = *read_number(key, value, options);
}

void Binder::optional_number(std::string_view key, std::optional<double>& value,
                             const NumberOptions& options) {
  CHECK(!value.has_value());
  value = read_number(key, std::nullopt, options);
}

const TableArray* Binder::declare_tables(std::string_view key, const TablesOptions& options) {
  const std::string name = fmt::format("[{}.{}]", section_name_, key);
  const Value* value = declare({.key = std::string(key),
                                .range = fmt::format("<= {} tables", options.count_max),
                                .expected = fmt::format("tables, each with the header [{}]", name),
                                .presence = Presence::optional,
                                .help = std::string(options.help)});
  arrays_.push_back({.key = std::string(key), .name = name, .specs = {}, .tables = {}});
  if (value == nullptr) return nullptr;
  const TableArray* array = section_->find_array(key);
  if (array == nullptr) {
    refuse(*value);
  } else if (array->tables.size() > options.count_max) {
    fail(key, array->tables[options.count_max].place,
         fmt::format("expected at most {} tables [{}], found {}", options.count_max, name,
                     array->tables.size()));
    array = nullptr;
  }
  return array;
}

void Binder::angle_deg(std::string_view key, double& value_rad, const NumberOptions& options) {
  NumberOptions in_degrees = options;
  in_degrees.unit = "degrees";
  const double fallback = degrees_of_radians(value_rad);
  const double degrees = *read_number(key, fallback, in_degrees);
  // Don't convert an unchanged default, so that it keeps its exact bits.
  if (degrees != fallback) value_rad = radians_of_degrees(degrees);
}

std::optional<std::int64_t> Binder::read_integer(std::string_view key,
                                                 std::optional<std::int64_t> fallback,
                                                 Presence presence, const IntegerOptions& options) {
  KeySpec spec{.key = std::string(key),
               .unit = std::string(options.unit),
               .presence = presence,
               .help = std::string(options.help)};
  if (fallback) {
    CHECK(*fallback >= options.minimum && *fallback <= options.maximum);
    spec.fallback = fmt::format("{}", *fallback);
  }
  describe_range(options, spec);

  std::optional<std::int64_t> integer = fallback;
  if (const Value* value = declare(std::move(spec))) {
    const auto* found = std::get_if<std::int64_t>(&value->held);
    if (found != nullptr && *found >= options.minimum && *found <= options.maximum) {
      integer = *found;
    } else {
      const bool is_number = std::holds_alternative<double>(value->held);
      refuse(*value, is_number ? "; an integer has no '.' and no exponent" : "");
    }
  }
  if (integer) keys_.back().value = fmt::format("{}", *integer);
  return integer;
}

void Binder::boolean(std::string_view key, bool& value, std::string_view help) {
  const Value* given_value = declare({.key = std::string(key),
                                      .range = "true or false",
                                      .expected = "true or false",
                                      .fallback = value ? "true" : "false",
                                      .help = std::string(help)});
  if (given_value != nullptr) {
    if (const bool* found = std::get_if<bool>(&given_value->held)) {
      value = *found;
    } else {
      refuse(*given_value);
    }
  }
  keys_.back().value = value ? "true" : "false";
}

void Binder::text(std::string_view key, std::string& value, const TextOptions& options) {
  CHECK_LE(character_count(value), options.characters_max);
  const std::string expected =
      fmt::format("a string of at most {} characters", options.characters_max);
  const Value* given_value =
      declare({.key = std::string(key),
               .range = fmt::format("<= {} characters", options.characters_max),
               .expected = expected,
               .fallback = toml_string(value),
               .help = std::string(options.help)});
  if (given_value != nullptr) {
    const auto* found = std::get_if<std::string>(&given_value->held);
    if (found != nullptr && character_count(*found) <= options.characters_max) {
      value = *found;
    } else {
      std::string hint;
      if (found != nullptr) {
        hint = fmt::format(", which has {} characters", character_count(*found));
      } else if (!std::holds_alternative<Unwanted>(given_value->held)) {
        const bool is_set = given_value->place == k_no_place;
        hint = fmt::format("; a string needs quotes: {}\"{}\"{}",
                           is_set ? fmt::format("--set '{}.{}=", section_name_, key) : "",
                           description(*given_value), is_set ? "'" : "");
      }
      refuse(*given_value, hint);
    }
  }
  keys_.back().value = toml_string(value);
}

std::optional<std::size_t> Binder::read_choice(std::string_view key,
                                               std::optional<std::size_t> fallback,
                                               const std::vector<std::string>& names,
                                               Presence presence, std::string_view help) {
  std::vector<std::string> quoted;
  for (const std::string& name : names)
    quoted.push_back(toml_string(name));
  CHECK(!quoted.empty());
  const std::string one_of = fmt::format("{}", fmt::join(quoted, ", "));
  const Value* value = declare({.key = std::string(key),
                                .range = fmt::format("{}", fmt::join(quoted, " | ")),
                                .expected = quoted.size() == 1 ? one_of : "one of " + one_of,
                                .fallback = fallback ? quoted[*fallback] : "",
                                .presence = presence,
                                .help = std::string(help)});

  std::optional<std::size_t> chosen = fallback;
  if (value != nullptr) {
    const auto* found = std::get_if<std::string>(&value->held);
    const auto at = found == nullptr ? names.end() : std::find(names.begin(), names.end(), *found);
    if (at != names.end()) {
      chosen = static_cast<std::size_t>(at - names.begin());
    } else {
      const auto near = found == nullptr ? std::nullopt : nearest(*found, names);
      refuse(*value, near ? fmt::format("; did you mean \"{}\"?", *near) : "");
    }
  }
  if (chosen) keys_.back().value = quoted[*chosen];
  return chosen;
}

void Binder::settle(std::string_view key, std::string value) {
  const auto bound = std::find_if(keys_.begin(), keys_.end(),
                                  [&](const BoundKey& b) { return b.spec.key == key; });
  CHECK(bound != keys_.end());
  bound->value = std::move(value);
}

bool Binder::given(std::string_view key) const {
  return section_ != nullptr && section_->find(key) != nullptr;
}

bool Binder::valid(std::string_view key) const {
  const bool declared = std::any_of(keys_.begin(), keys_.end(),
                                    [&](const BoundKey& bound) { return bound.spec.key == key; });
  return declared && std::find(invalid_.begin(), invalid_.end(), key) == invalid_.end();
}

void Binder::error(std::string_view key, std::string_view message) {
  const Entry* entry = section_ == nullptr ? nullptr : section_->find(key);
  const Place place = entry != nullptr      ? entry->place
                      : section_ != nullptr ? section_->place
                                            : Place{};
  fail(key, place, message);
}

}  // namespace sleight::request
