#include "common/request/sets.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <utility>

#include "common/base/check.h"
#include "common/request/text.h"

namespace sleight::request {
namespace {

constexpr std::size_t k_text_characters_max = 80;
constexpr std::string_view k_form = "expected SECTION.KEY=VALUE, for example sampler.seed=7";

Diagnostic wrong(std::string_view text, std::string message) {
  return {printable(fmt::format("--set {}", text), k_text_characters_max), k_no_place,
          std::move(message)};
}

/// A `--set` option before its ranges are expanded.
struct Written {
  std::string section;
  std::string key;
  std::string_view value;
};

base::Result<Written, std::string> split(std::string_view text) {
  if (!is_utf8(text)) return std::string("expected UTF-8 text");
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos) return std::string(k_form);
  const std::string_view path = text.substr(0, equals);
  const std::size_t dot = path.find('.');
  Written written{.section = {}, .key = std::string(path), .value = text.substr(equals + 1)};
  if (dot != std::string_view::npos) {
    written.section = path.substr(0, dot);
    written.key = path.substr(dot + 1);
    if (written.section.empty()) return std::string(k_form);
  }
  if (written.key.empty()) return std::string(k_form);
  if (written.key.find('.') != std::string::npos)
    return fmt::format("{}; keys of a table within a section can be set only in the request file",
                       k_form);
  if (written.value.empty())
    return std::string("missing value after '='; write an empty string as '\"\"'");
  return written;
}

/// Returns the text's TOML value. If the text is not TOML, returns it as a string.
base::Result<Value, std::string> value_of(std::string_view text) {
  const std::string name = "value";
  auto document = parse_document(fmt::format("{} = {}\n", name, text), "");
  if (document) {
    const std::vector<Entry>& entries = document.value().loose;
    // If the document has more than one entry, `text` has several lines.
    if (entries.size() == 1 && entries.front().key == name && document.value().sections.empty())
      return Value{entries.front().value.held, k_no_place};
  } else if (std::string_view("\"'[{").find(text.front()) != std::string_view::npos) {
    return document.error().message;
  }
  return Value{std::string(text), k_no_place};
}

struct IntegerRange {
  std::int64_t first = 0;
  std::int64_t last = 0;
};

/// Parses "1..20"; nothing if the text is not a range.
std::optional<IntegerRange> range_of(std::string_view text) {
  IntegerRange range;
  const char* end = text.data() + text.size();
  const auto [dots, no_first] = std::from_chars(text.data(), end, range.first);
  if (no_first != std::errc() || !std::string_view(dots, end).starts_with(".."))
    return std::nullopt;
  const auto [rest, no_last] = std::from_chars(dots + 2, end, range.last);
  if (no_last != std::errc() || rest != end) return std::nullopt;
  return range;
}

/// Splits "{1,4,16}" at commas outside quotes and brackets; nothing if the text is not a list.
std::optional<std::vector<std::string_view>> items_of(std::string_view text) {
  if (text.size() < 2 || text.front() != '{' || text.back() != '}') return std::nullopt;
  text = text.substr(1, text.size() - 2);
  std::vector<std::string_view> items;
  std::size_t start = 0;
  char quote = 0;
  int depth = 0;
  for (std::size_t i = 0; i <= text.size(); ++i) {
    const bool is_end = i == text.size();
    if (!is_end && quote == '"' && text[i] == '\\') {
      ++i;
    } else if (!is_end && (text[i] == '"' || text[i] == '\'')) {
      if (quote == 0) {
        quote = text[i];
      } else if (quote == text[i]) {
        quote = 0;
      }
    } else if (!is_end && quote == 0 && (text[i] == '[' || text[i] == '{')) {
      ++depth;
    } else if (!is_end && quote == 0 && (text[i] == ']' || text[i] == '}')) {
      --depth;
    } else if (is_end || (text[i] == ',' && quote == 0 && depth == 0)) {
      items.push_back(text.substr(start, i - start));
      start = i + 1;
    }
  }
  return items;
}

struct Values {
  std::vector<std::string> texts;
  bool is_range = false;
};

std::string too_many() {
  return fmt::format("the limit for a group is {} requests", k_combinations_max);
}

/// Adds the values of an item, which may be a range. Returns the error, if any.
std::optional<std::string> spread(std::string_view item, Values& values) {
  const std::optional<IntegerRange> range = range_of(item);
  if (!range) {
    if (item.empty()) return "the list has an empty item";
    values.texts.emplace_back(item);
    return std::nullopt;
  }
  values.is_range = true;
  if (range->last < range->first) {
    return fmt::format("the range {}..{} is empty: its first number is above its last",
                       range->first, range->last);
  }
  const std::uint64_t steps =
      static_cast<std::uint64_t>(range->last) - static_cast<std::uint64_t>(range->first);
  if (steps >= k_combinations_max - std::min(values.texts.size(), k_combinations_max))
    return too_many();
  for (std::uint64_t step = 0; step <= steps; ++step) {
    const auto value = static_cast<std::int64_t>(static_cast<std::uint64_t>(range->first) + step);
    values.texts.push_back(fmt::format("{}", value));
  }
  return std::nullopt;
}

base::Result<Values, std::string> values_of(std::string_view text) {
  Values values;
  const auto items = items_of(text);
  values.is_range = items.has_value();
  for (const std::string_view item : items.value_or(std::vector{text})) {
    if (const auto reason = spread(item, values)) return *reason;
  }
  return values;
}

struct Spread {
  std::vector<KeySet> choices;
  bool is_range = false;
};

base::Result<Spread, std::string> read_set(std::string_view text) {
  const auto written = split(text);
  if (!written) return written.error();
  const auto values = values_of(written.value().value);
  if (!values) return values.error();
  Spread set{.choices = {}, .is_range = values.value().is_range};
  for (const std::string& value_text : values.value().texts) {
    const auto value = value_of(value_text);
    if (!value) return value.error();
    const std::string path = written.value().section.empty()
                                 ? written.value().key
                                 : written.value().section + "." + written.value().key;
    set.choices.push_back({printable(fmt::format("{}={}", path, value_text), k_text_characters_max),
                           written.value().section, written.value().key, value.value()});
  }
  return set;
}

struct ReadSets {
  std::vector<Spread> sets;
  std::size_t combinations = 1;
};

base::Result<ReadSets, std::vector<Diagnostic>> read_sets(std::span<const std::string> texts) {
  ReadSets read;
  std::vector<Diagnostic> errors;
  if (texts.size() > k_sets_max)
    return std::vector{
        wrong(texts[k_sets_max], fmt::format("expected at most {} --set options", k_sets_max))};
  for (const std::string& text : texts) {
    auto set = read_set(text);
    if (!set) {
      errors.push_back(wrong(text, set.error()));
      continue;
    }
    const KeySet& first = set.value().choices.front();
    for (const Spread& other : read.sets) {
      const KeySet& same = other.choices.front();
      if (same.section == first.section && same.key == first.key)
        errors.push_back(wrong(text, "the key is set twice; remove one of the two"));
    }
    // The product can't overflow, because neither factor exceeds the limit for combinations.
    read.combinations *= set.value().choices.size();
    if (read.combinations > k_combinations_max) {
      errors.push_back(wrong(text, too_many()));
      read.combinations = 1;
    }
    read.sets.push_back(std::move(set).value());
  }
  if (!errors.empty()) return errors;
  return read;
}

/// Moves a value, and what is in it, to the place.
void move_to(Place place, Value& value) {
  value.place = place;
  if (auto* array = std::get_if<std::vector<Value>>(&value.held)) {
    for (Value& element : *array)
      move_to(place, element);
  }
}

}  // namespace

base::Result<std::vector<std::vector<KeySet>>, std::vector<Diagnostic>> expand_sets(
    std::span<const std::string> texts) {
  const auto read = read_sets(texts);
  if (!read) return read.error();
  std::vector<std::vector<KeySet>> combinations(1);
  for (const Spread& set : read.value().sets) {
    std::vector<std::vector<KeySet>> longer;
    longer.reserve(combinations.size() * set.choices.size());
    for (const std::vector<KeySet>& shorter : combinations) {
      for (const KeySet& choice : set.choices)
        longer.emplace_back(shorter).push_back(choice);
    }
    combinations = std::move(longer);
  }
  CHECK_EQ(combinations.size(), read.value().combinations);
  return combinations;
}

base::Result<std::vector<KeySet>, std::vector<Diagnostic>> plain_sets(
    std::span<const std::string> texts) {
  const auto read = read_sets(texts);
  if (!read) return read.error();
  std::vector<KeySet> sets;
  std::vector<Diagnostic> errors;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    const Spread& set = read.value().sets[i];
    if (set.is_range) {
      errors.push_back(wrong(texts[i],
                             "expected one value, found a range; only `sleight submit` accepts "
                             "ranges"));
    }
    sets.push_back(set.choices.front());
  }
  if (!errors.empty()) return errors;
  return sets;
}

const KeySet* find_set(std::span<const KeySet> sets, std::string_view section,
                       std::string_view key) {
  const auto at = std::find_if(sets.begin(), sets.end(), [&](const KeySet& set) {
    return set.section == section && (key.empty() || set.key == key);
  });
  return at == sets.end() ? nullptr : &*at;
}

void apply_sets(Document& document, std::span<const KeySet> sets) {
  for (std::size_t i = 0; i < sets.size(); ++i) {
    const KeySet& set = sets[i];
    const Place place{0, static_cast<std::uint32_t>(i) + 1};
    Entry entry{.key = set.key, .place = place, .value = set.value};
    move_to(place, entry.value);
    if (set.section.empty()) {
      document.loose.push_back(std::move(entry));
      continue;
    }
    auto section = std::ranges::find(document.sections, set.section, &Section::name);
    if (section == document.sections.end())
      section =
          document.sections.insert(section, {.name = set.section, .place = place, .entries = {}});
    std::erase_if(section->entries, [&](const Entry& old) { return old.key == entry.key; });
    section->entries.push_back(std::move(entry));
  }
}

}  // namespace sleight::request
