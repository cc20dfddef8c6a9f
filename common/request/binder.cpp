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
  spec.unit = options.unit;
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
  spec.unit = options.unit;
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

void describe_range(const TextOptions& options, KeySpec& spec) {
  spec.range = fmt::format("<= {} characters", options.characters_max);
  spec.expected = fmt::format("a string of at most {} characters", options.characters_max);
}

bool in_range(double number, const NumberOptions& options) {
  return std::isfinite(number) &&
         (options.above_minimum ? number > options.minimum : number >= options.minimum) &&
         (options.below_maximum ? number < options.maximum : number <= options.maximum);
}

/// Returns a value's element if it has the right type and range.
std::optional<double> element_of(const Value& value, const NumberOptions& options) {
  double found = std::numeric_limits<double>::quiet_NaN();
  if (const auto* number = std::get_if<double>(&value.held)) found = *number;
  if (const auto* integer = std::get_if<std::int64_t>(&value.held))
    found = static_cast<double>(*integer);
  if (!in_range(found, options)) return std::nullopt;
  return found + 0.0;  // -0 becomes 0
}

std::optional<std::int64_t> element_of(const Value& value, const IntegerOptions& options) {
  const auto* found = std::get_if<std::int64_t>(&value.held);
  if (found == nullptr || *found < options.minimum || *found > options.maximum) return std::nullopt;
  return *found;
}

std::optional<std::string> element_of(const Value& value, const TextOptions& options) {
  const auto* found = std::get_if<std::string>(&value.held);
  if (found == nullptr || character_count(*found) > options.characters_max) return std::nullopt;
  return *found;
}

std::string toml_of(double number) {
  return toml_number(number);
}
std::string toml_of(std::int64_t integer) {
  return fmt::format("{}", integer);
}
std::string toml_of(const std::string& text) {
  return toml_string(text);
}

std::string_view noun(const NumberOptions& /*each*/) {
  return "number";
}
std::string_view noun(const IntegerOptions& /*each*/) {
  return "integer";
}
std::string_view noun(const TextOptions& /*each*/) {
  return "string";
}

std::string counted(std::size_t count, std::string_view noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

/// Returns "3 numbers" or "1 to 9 rows".
std::string counted(std::size_t count_min, std::size_t count_max, std::string_view noun) {
  return (count_min == count_max ? "" : fmt::format("{} to ", count_min)) +
         counted(count_max, noun);
}

/// Returns the elements of an array, or null if it isn't one, or has another number of elements.
const std::vector<Value>* elements_of(const Value& value, std::size_t count_min,
                                      std::size_t count_max) {
  const auto* array = std::get_if<std::vector<Value>>(&value.held);
  const bool fits = array != nullptr && array->size() >= count_min && array->size() <= count_max;
  return fits ? array : nullptr;
}

/// Tells why a value isn't an element. `key` is its name in a `--set`.
std::string hint_of(const Value& /*value*/, const NumberOptions& /*options*/,
                    std::string_view /*key*/) {
  return "";
}

std::string hint_of(const Value& value, const IntegerOptions& /*options*/,
                    std::string_view /*key*/) {
  const bool is_number = std::holds_alternative<double>(value.held);
  return is_number ? "; an integer has no '.' and no exponent" : "";
}

std::string hint_of(const Value& value, const TextOptions& /*options*/, std::string_view key) {
  if (const auto* text = std::get_if<std::string>(&value.held))
    return fmt::format(", which has {} characters", character_count(*text));
  const bool is_scalar = std::holds_alternative<std::int64_t>(value.held) ||
                         std::holds_alternative<double>(value.held) ||
                         std::holds_alternative<bool>(value.held);
  if (!is_scalar) return "";
  const bool is_set = value.place == k_no_place;
  return fmt::format("; a string needs quotes: {}\"{}\"{}",
                     is_set ? fmt::format("--set '{}=", key) : "", description(value),
                     is_set ? "'" : "");
}

std::string_view key_of(const BoundKey& bound) {
  return bound.spec.key;
}

std::string found_in(const Value& value) {
  const auto* array = std::get_if<std::vector<Value>>(&value.held);
  return array == nullptr ? description(value) : fmt::format("an array of {}", array->size());
}

template <class Element>
std::string toml_of_rows(const std::vector<Element>& elements, std::size_t columns, bool is_rows) {
  std::string text = "[";
  for (std::size_t i = 0; i < elements.size(); ++i) {
    if (i > 0) text += is_rows && i % columns == 0 ? "], " : ", ";
    if (is_rows && i % columns == 0) text += '[';
    text += toml_of(elements[i]);
  }
  return text + (is_rows && !elements.empty() ? "]]" : "]");
}

}  // namespace

struct Binder::ExpectedElements {
  std::string element;
  std::string row;
};

Binder::Binder(std::string section_name, const Section* section, Diagnostics& diagnostics)
    : section_name_(std::move(section_name)), section_(section), diagnostics_(diagnostics) {}

const Value* Binder::declare(KeySpec spec) {
  for (const BoundKey& bound : bound_.keys)
    CHECK_NE(bound.spec.key, spec.key);
  const Entry* entry = section_ == nullptr ? nullptr : section_->find(spec.key);
  if (entry == nullptr && section_ != nullptr && spec.presence == Presence::required) {
    fail(spec.key, section_->place, fmt::format("missing; expected {}", spec.expected));
  }
  bound_.keys.push_back({std::move(spec), ""});
  return entry == nullptr ? nullptr : &entry->value;
}

void Binder::fail(std::string_view key, Place place, std::string_view message) {
  invalid_.emplace_back(key);
  diagnostics_.add(place, fmt::format("'{}' in [{}]: {}", key, section_name_, message));
}

void Binder::refuse(const Value& value, std::string_view hint) {
  const KeySpec& spec = bound_.keys.back().spec;
  fail(spec.key, value.place,
       fmt::format("expected {}, found {}{}", spec.expected, description(value), hint));
}

template <class Element, class Options>
std::optional<Element> Binder::read(std::string_view key, std::optional<Element> fallback,
                                    Presence presence, const Options& options) {
  KeySpec spec{.key = std::string(key), .presence = presence, .help = std::string(options.help)};
  describe_range(options, spec);
  if (fallback) {
    CHECK(element_of(Value{.held = *fallback, .place = {}}, options).has_value());
    spec.fallback = toml_of(*fallback);
  }
  std::optional<Element> read = std::move(fallback);
  if (const Value* value = declare(std::move(spec))) {
    if (auto found = element_of(*value, options)) {
      read = std::move(found);
    } else {
      refuse(*value, hint_of(*value, options, fmt::format("{}.{}", section_name_, key)));
    }
  }
  if (read) bound_.keys.back().value = toml_of(*read);
  return read;
}

template std::optional<double> Binder::read(std::string_view, std::optional<double>, Presence,
                                            const NumberOptions&);
template std::optional<std::int64_t> Binder::read(std::string_view, std::optional<std::int64_t>,
                                                  Presence, const IntegerOptions&);
template std::optional<std::string> Binder::read(std::string_view, std::optional<std::string>,
                                                 Presence, const TextOptions&);

void Binder::number(std::string_view key, double& value, const NumberOptions& options) {
  value = *read<double>(key, value, Presence::defaulted, options);
}

void Binder::numbers(std::string_view key, std::vector<double>& values, const ListOptions& list,
                     const NumberOptions& each) {
  CHECK(values.empty());
  const Shape shape{.rows_min = list.count_min, .rows_max = list.count_max};
  values = read_array<double>(key, shape, nullptr, list.required, each).value_or(values);
}

void Binder::texts(std::string_view key, std::vector<std::string>& values, const ListOptions& list,
                   const TextOptions& each) {
  CHECK(values.empty());
  const Shape shape{.rows_min = list.count_min, .rows_max = list.count_max};
  values = read_array<std::string>(key, shape, nullptr, list.required, each).value_or(values);
}

template <class Element, class Options>
std::optional<std::vector<Element>> Binder::read_array(std::string_view key, const Shape& shape,
                                                       const std::vector<Element>* fallback,
                                                       bool required, const Options& each) {
  CHECK(shape.rows_min <= shape.rows_max && shape.columns > 0);
  CHECK_LE(shape.rows_max, k_array_numbers_max / shape.columns);
  KeySpec spec{.key = std::string(key), .help = std::string(each.help)};
  spec.presence = required              ? Presence::required
                  : fallback != nullptr ? Presence::defaulted
                                        : Presence::optional;
  describe_range(each, spec);
  const std::string row =
      fmt::format("{}, each {}", counted(shape.columns, noun(each)), spec.expected);
  const ExpectedElements expected{spec.expected, row};
  const std::string rows =
      counted(shape.rows_min, shape.rows_max, shape.is_rows ? "row" : noun(each));
  spec.range = shape.is_rows ? fmt::format("{} of {} in {}", rows, shape.columns, spec.range)
                             : fmt::format("{} in {}", rows, spec.range);
  spec.expected = shape.is_rows ? fmt::format("{} of {}", rows, row)
                                : fmt::format("{}, each {}", rows, spec.expected);
  std::optional<std::vector<Element>> elements;
  if (fallback != nullptr) {
    for (const Element& element : *fallback)
      CHECK(element_of(Value{.held = element, .place = {}}, each).has_value());
    elements = *fallback;
    spec.fallback = toml_of_rows(*elements, shape.columns, shape.is_rows);
  }
  if (const Value* value = declare(std::move(spec))) {
    std::vector<Element> found;
    if (read_elements(*value, shape, expected, each, found)) elements = std::move(found);
  }
  if (elements) bound_.keys.back().value = toml_of_rows(*elements, shape.columns, shape.is_rows);
  return elements;
}

template <class Element, class Options>
bool Binder::read_elements(const Value& value, const Shape& shape, const ExpectedElements& expected,
                           const Options& each, std::vector<Element>& found) {
  const std::size_t errors_before = invalid_.size();
  const std::string key = bound_.keys.back().spec.key;
  const auto refuse_at = [&](const std::string& where, const Value& wrong, std::string_view right) {
    fail(key, wrong.place, fmt::format("{}expected {}, found {}", where, right, found_in(wrong)));
  };
  const auto* rows = elements_of(value, shape.rows_min, shape.rows_max);
  if (rows == nullptr) refuse_at("", value, bound_.keys.back().spec.expected);
  for (std::size_t i = 0; rows != nullptr && i < rows->size(); ++i) {
    const std::span<const Value> one(&(*rows)[i], 1);
    const auto* array = shape.is_rows ? elements_of(one[0], shape.columns, shape.columns) : nullptr;
    if (shape.is_rows && array == nullptr) {
      refuse_at(fmt::format("row {}: ", i + 1), one[0], expected.row);
      continue;
    }
    const std::span<const Value> row = array == nullptr ? one : std::span(*array);
    for (std::size_t j = 0; j < row.size(); ++j) {
      if (auto element = element_of(row[j], each)) {
        found.push_back(std::move(*element));
      } else {
        refuse_at(shape.is_rows ? fmt::format("row {}, element {}: ", i + 1, j + 1)
                                : fmt::format("element {}: ", i + 1),
                  row[j], expected.element);
      }
    }
  }
  return invalid_.size() == errors_before;
}

template std::optional<std::vector<double>> Binder::read_array(std::string_view, const Shape&,
                                                               const std::vector<double>*, bool,
                                                               const NumberOptions&);
template std::optional<std::vector<std::int64_t>> Binder::read_array(
    std::string_view, const Shape&, const std::vector<std::int64_t>*, bool, const IntegerOptions&);
template std::optional<std::vector<std::string>> Binder::read_array(std::string_view, const Shape&,
                                                                    const std::vector<std::string>*,
                                                                    bool, const TextOptions&);

BoundTables Binder::named_tables(std::string_view key, bool is_array) const {
  std::string_view parent = section_name_;
  if (parent.starts_with('[')) parent = parent.substr(1, parent.size() - 2);
  return {
      .key = std::string(key),
      .name = is_array ? fmt::format("[{}.{}]", parent, key) : fmt::format("{}.{}", parent, key),
      .described = {},
      .tables = {}};
}

std::vector<const Section*> Binder::declare_tables(const BoundTables& tables,
                                                   const TablesOptions& options) {
  const Value* value =
      declare({.key = tables.key,
               .range = fmt::format("<= {} tables", options.count_max),
               .expected = fmt::format("tables, each with the header [{}]", tables.name),
               .presence = Presence::optional,
               .help = std::string(options.help)});
  if (value == nullptr) return {};
  std::vector<const Section*> given = section_->tables(tables.key);
  const bool is_set = value->place.line == 0;
  if (given.empty() || is_set) {
    refuse(*value);
    given.clear();
  } else if (given.size() > options.count_max) {
    fail(tables.key, given[options.count_max]->place,
         fmt::format("expected at most {} tables [{}], found {}", options.count_max, tables.name,
                     given.size()));
    given.clear();
  }
  return given;
}

const Section* Binder::declare_table(const BoundTables& table, std::string_view help) {
  const Value* value = declare({.key = table.key,
                                .range = "a table",
                                .expected = fmt::format("a table with the header [{}]", table.name),
                                .presence = Presence::optional,
                                .help = std::string(help)});
  if (value == nullptr) return nullptr;
  const Section* given = section_->table(table.key);
  if (given == nullptr) refuse(*value);
  return given;
}

void Binder::angle_deg(std::string_view key, double& value_rad, const NumberOptions& options) {
  NumberOptions in_degrees = options;
  in_degrees.unit = "degrees";
  const double fallback = degrees_of_radians(value_rad);
  const double degrees = *read<double>(key, fallback, Presence::defaulted, in_degrees);
  // Don't convert an unchanged default, so that it keeps its exact bits.
  if (degrees != fallback) value_rad = radians_of_degrees(degrees);
}

void Binder::length_mm(std::string_view key, double& value_m, NumberOptions options) {
  options.unit = "mm";
  const double fallback_mm = std::round(value_m * 1e12) / 1e9;
  value_m = *read<double>(key, fallback_mm, Presence::defaulted, options) / 1e3;
}

void Binder::shares(std::initializer_list<Share> all) {
  double sum = 0;
  bool are_valid = true;
  for (const Share& share : all) {
    number(share.key, share.value, {.minimum = 0, .maximum = 1, .help = share.help});
    sum += share.value;
    are_valid = are_valid && valid(share.key);
  }
  if (are_valid && std::fabs(sum - 1) > 1e-9)
    error(all.begin()->key, fmt::format("the shares must add up to 1, found {:.6g}", sum));
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
  bound_.keys.back().value = value ? "true" : "false";
}

void Binder::text(std::string_view key, std::string& value, const TextOptions& options) {
  value = *read<std::string>(key, value, Presence::defaulted, options);
}

std::optional<std::size_t> Binder::read_choice(std::string_view key,
                                               std::optional<std::size_t> fallback,
                                               const std::vector<std::string>& names,
                                               std::string_view help) {
  std::vector<std::string> quoted;
  for (const std::string& name : names)
    quoted.push_back(toml_string(name));
  CHECK(!quoted.empty());
  const std::string one_of = fmt::format("{}", fmt::join(quoted, ", "));
  const Value* value = declare({.key = std::string(key),
                                .range = fmt::format("{}", fmt::join(quoted, " | ")),
                                .expected = quoted.size() == 1 ? one_of : "one of " + one_of,
                                .fallback = fallback ? quoted[*fallback] : "",
                                .presence = fallback ? Presence::defaulted : Presence::required,
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
  if (chosen) bound_.keys.back().value = quoted[*chosen];
  return chosen;
}

void Binder::settle(std::string_view key, std::string value) {
  const auto bound = std::ranges::find(bound_.keys, key, key_of);
  CHECK(bound != bound_.keys.end());
  bound->value = std::move(value);
}

bool Binder::given(std::string_view key) const {
  return section_ != nullptr && section_->find(key) != nullptr;
}

bool Binder::valid(std::string_view key) const {
  return std::ranges::find(bound_.keys, key, key_of) != bound_.keys.end() &&
         std::ranges::find(invalid_, key) == invalid_.end();
}

void Binder::error(std::string_view key, std::string_view message) {
  const Entry* entry = section_ == nullptr ? nullptr : section_->find(key);
  const Place place = entry != nullptr      ? entry->place
                      : section_ != nullptr ? section_->place
                                            : Place{};
  fail(key, place, message);
}

}  // namespace sleight::request
