// The parser of queries (query.h): one function per rule. Each function stops at the first token
// that it doesn't use.
#include <algorithm>
#include <array>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "clients/browse/query.h"
#include "clients/browse/tokens.h"
#include "common/base/check.h"
#include "common/request/nearest.h"

namespace sleight::browse {
namespace {

enum class Dimension : std::uint8_t { none, length, time, angle, speed };
constexpr std::array<std::string_view, 5> k_dimension_words{"a pure number", "a length", "a time",
                                                            "an angle", "a speed"};

struct Unit {
  std::string_view name;
  Dimension dimension;
  double si;  ///< value of one unit in SI
};
constexpr std::array k_units{
    Unit{"um", Dimension::length, 1e-6}, Unit{"mm", Dimension::length, 1e-3},
    Unit{"cm", Dimension::length, 1e-2}, Unit{"m", Dimension::length, 1},
    Unit{"us", Dimension::time, 1e-6},   Unit{"ms", Dimension::time, 1e-3},
    Unit{"s", Dimension::time, 1},       Unit{"deg", Dimension::angle, std::numbers::pi / 180},
    Unit{"rad", Dimension::angle, 1},    Unit{"mm/s", Dimension::speed, 1e-3},
    Unit{"m/s", Dimension::speed, 1}};

constexpr std::array<std::string_view, 13> k_keywords{
    "and", "or", "not", "in", "touches", "ends", "then", "during", "any", "every", "x", "y", "z"};

Dimension dimension_of(std::string_view unit_of_archive) {
  if (unit_of_archive == "m") return Dimension::length;
  if (unit_of_archive == "s") return Dimension::time;
  if (unit_of_archive == "rad") return Dimension::angle;
  if (unit_of_archive == "m s-1") return Dimension::speed;
  return Dimension::none;
}

const Unit* find_unit(std::string_view name) {
  const auto found = std::ranges::find(k_units, name, &Unit::name);
  return found == k_units.end() ? nullptr : &*found;
}

bool is_keyword(std::string_view word) {
  return std::ranges::find(k_keywords, word) != k_keywords.end();
}

/// Names of numbers in the gallery, and their names in a query.
struct OtherWord {
  std::string_view word;
  std::string_view name;
};
constexpr std::array k_other_words{OtherWord{"score", "log_constraint"},
                                   OtherWord{"plausibility", "log_prior"}};

constexpr const char* k_then_joins = "'then' can only join '... in BOX' and '... touches ...'";

/// The rules throw a Fault, which only parse_query catches. Returning results through ten levels of
/// rules would hide the grammar.
struct Fault {
  QueryError error;
};

struct Ends {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
};

class Parser {
 public:
  Parser(std::vector<Token> tokens, const scene::Scene& scene,
         const std::vector<NumberName>& numbers)
      : tokens_(std::move(tokens)), scene_(scene), numbers_(numbers) {}

  Condition whole() {
    if (next().kind == Token::Kind::end) fail("expected a query, such as 'any in x 0..20mm'");
    Condition condition = any_of();
    if (next().kind != Token::Kind::end)
      fail("expected 'and', 'or', 'then' or the end of the query");
    return condition;
  }

 private:
  // Tokens.

  const Token& next() const { return tokens_[at_]; }
  const Token& after_next() const { return tokens_[std::min(at_ + 1, tokens_.size() - 1)]; }

  [[noreturn]] void fail_at(std::size_t column, std::string message) const {
    throw Fault{{.column = column, .message = std::move(message)}};
  }
  [[noreturn]] void fail(const std::string& message) const { fail_at(next().column, message); }

  bool is_word(std::string_view word) const {
    return next().kind == Token::Kind::word && next().text == word;
  }
  bool is_sign(std::string_view sign) const {
    return next().kind == Token::Kind::sign && next().text == sign;
  }
  bool take_word(std::string_view word) {
    if (!is_word(word)) return false;
    ++at_;
    return true;
  }
  bool take_sign(std::string_view sign) {
    if (!is_sign(sign)) return false;
    ++at_;
    return true;
  }

  // and, or, not, then.

  Condition any_of() {
    AnyOf any;
    do {
      any.parts.push_back(all_of());
    } while (take_word("or"));
    return any.parts.size() == 1 ? std::move(any.parts.front()) : Condition{std::move(any)};
  }

  Condition all_of() {
    AllOf all;
    do {
      all.parts.push_back(negated());
    } while (take_word("and"));
    return all.parts.size() == 1 ? std::move(all.parts.front()) : Condition{std::move(all)};
  }

  Condition negated() {
    if (++depth_ > k_query_depth_max)
      fail(fmt::format("the query is nested more than {} levels deep", k_query_depth_max));
    Condition condition;
    if (take_word("not")) {
      Not no;
      no.part.push_back(negated());
      condition = {std::move(no)};
    } else if (take_sign("(")) {
      condition = any_of();
      if (!take_sign(")")) fail("expected ')'");
    } else {
      condition = in_order();
    }
    --depth_;
    return condition;
  }

  Condition in_order() {
    const std::size_t column = next().column;
    Condition first = term();
    if (!is_word("then")) return first;
    InOrder order;
    require_moment(first, column);
    order.steps.push_back(std::move(first));
    while (take_word("then")) {
      const std::size_t begin = next().column;
      if (is_word("not") || is_sign("(")) fail(k_then_joins);
      order.steps.push_back(term());
      require_moment(order.steps.back(), begin);
    }
    return {std::move(order)};
  }

  void require_moment(const Condition& condition, std::size_t column) const {
    const bool has_moment = std::holds_alternative<Inside>(condition.is) ||
                            std::holds_alternative<Touches>(condition.is);
    if (!has_moment) fail_at(column, k_then_joins);
  }

  // Terms.

  Condition term() {
    const Token begin = next();
    if (is_word("any") || is_word("every")) return of_bodies(bodies_of_kind());
    const std::string name = taken_name();
    const bool is_of_number = (next().kind == Token::Kind::sign && next().text != ":" &&
                               next().text != ")" && next().text != ",") ||
                              next().kind == Token::Kind::number;
    if (is_of_number) return of_number(name, begin.column);
    return of_bodies({.bodies = {body_called(name, begin.column)}});
  }

  Condition of_bodies(Bodies who) {
    if (take_word("in") || take_sign(":")) {
      Inside inside{.who = std::move(who), .box = box()};
      inside.when = during();
      return {std::move(inside)};
    }
    if (take_word("touches")) {
      Touches touches{.who = std::move(who), .partners = partners()};
      touches.when = during();
      return {std::move(touches)};
    }
    if (take_word("ends")) {
      if (!take_word("in")) fail("expected 'in', as in '... ends in x 0..20mm'");
      return {EndsIn{.who = std::move(who), .box = box()}};
    }
    fail("expected 'in', 'touches' or 'ends in'");
  }

  Bodies bodies_of_kind() {
    Bodies who{.is_every = next().text == "every"};
    ++at_;
    const std::size_t column = next().column;
    const bool has_kind = (next().kind == Token::Kind::word && !is_keyword(next().text)) ||
                          next().kind == Token::Kind::quoted;
    const std::string kind = has_kind ? tokens_[at_++].text : std::string();
    for (std::uint32_t body = 0; body < scene_.bodies(); ++body) {
      const std::string& name = scene_.features[body].name;
      // "die" stands for "die 1", "die 2", ...
      const bool is_of_kind =
          kind.empty() || name == kind ||
          (name.starts_with(kind + " ") &&
           name.find_first_not_of("0123456789", kind.size() + 1) == std::string::npos);
      if (is_of_kind) who.bodies.push_back(body);
    }
    // "any body" means "any", unless bodies have that name.
    if (who.bodies.empty() && kind == "body") {
      for (std::uint32_t body = 0; body < scene_.bodies(); ++body)
        who.bodies.push_back(body);
    }
    if (who.bodies.empty()) {
      fail_at(column, kind.empty() ? std::string("the scene has no bodies")
                                   : fmt::format("no body is named '{} N'; the bodies are {}", kind,
                                                 shown_names(scene_.bodies())));
    }
    return who;
  }

  std::vector<std::uint32_t> partners() {
    if (take_word("any")) return {};
    const std::size_t column = next().column;
    const std::string name = taken_name();
    const auto found = scene_.find(name);
    if (!found) fail_unknown(name, scene_.features.size(), column);
    if (scene_.features[*found].kind == scene::FeatureKind::wanted)
      fail_at(column,
              fmt::format(
                  "'{}' is a goal, which bodies cannot touch; use 'in' with the place of the goal",
                  name));
    return {*found};
  }

  /// Reads words with the plain numbers after them, or one quoted name.
  std::string taken_name() {
    if (next().kind == Token::Kind::quoted) return tokens_[at_++].text;
    if (next().kind != Token::Kind::word || is_keyword(next().text))
      fail("expected a body, 'any', 'every' or the name of a number");
    std::string name = tokens_[at_++].text;
    while (true) {
      const bool is_more_words = next().kind == Token::Kind::word && !is_keyword(next().text);
      // The 3 in "die 3 in" belongs to the name; the 3 in "bounces 3..5" doesn't.
      const bool is_its_number =
          next().kind == Token::Kind::number &&
          next().text.find_first_not_of("0123456789") == std::string::npos &&
          !(after_next().kind == Token::Kind::sign && after_next().text == "..") &&
          !(after_next().kind == Token::Kind::word &&
            (after_next().is_joined || find_unit(after_next().text) != nullptr));
      if (!is_more_words && !is_its_number) return name;
      name += " " + tokens_[at_++].text;
    }
  }

  std::string shown_names(std::size_t count) const {
    constexpr std::size_t k_shown = 12;
    std::string names;
    for (std::size_t i = 0; i < std::min(count, k_shown); ++i)
      names += fmt::format("{}{}", i == 0 ? "" : ", ", scene_.features[i].name);
    if (count > k_shown) names += fmt::format(" and {} more", count - k_shown);
    return names;
  }

  [[noreturn]] void fail_unknown(const std::string& name, std::size_t features,
                                 std::size_t column) const {
    std::vector<std::string> known;
    for (std::size_t i = 0; i < features; ++i)
      known.push_back(scene_.features[i].name);
    const auto near = request::nearest(name, known);
    fail_at(column, near ? fmt::format("nothing is named '{}'; did you mean '{}'?", name, *near)
                         : fmt::format("nothing is named '{}'; the names are {}", name,
                                       shown_names(features)));
  }

  std::uint32_t body_called(const std::string& name, std::size_t column) const {
    const auto found = scene_.find(name);
    if (found && *found < scene_.bodies()) return *found;
    if (found)
      fail_at(column,
              fmt::format("'{}' doesn't move; use 'touches', as in 'any touches {}'", name, name));
    if (number_called(name)) {
      fail_at(column,
              fmt::format(
                  "'{}' is a number; expected a range or a comparison after it, as in '{} 0..1'",
                  name, name));
    }
    fail_unknown(name, scene_.bodies(), column);
  }

  // Numbers.

  std::optional<std::size_t> number_called(std::string_view name) const {
    const auto found = std::ranges::find(numbers_, name, &NumberName::name);
    if (found == numbers_.end()) return std::nullopt;
    return static_cast<std::size_t>(found - numbers_.begin());
  }

  Condition of_number(std::string name, std::size_t column) {
    while (take_sign("[")) {
      name += '[';
      while (!take_sign("]")) {
        if (next().kind != Token::Kind::number && !is_sign(",")) fail("expected ']'");
        name += tokens_[at_++].text;
      }
      name += ']';
    }
    const auto number = number_called(name);
    if (!number) fail_no_number(name, column);
    const Dimension dimension = dimension_of(numbers_[*number].unit);
    NumberIn in{.number = *number};
    constexpr std::array<std::string_view, 5> k_comparisons{"<", "<=", ">", ">=", "="};
    const auto comparison =
        std::ranges::find_if(k_comparisons, [&](std::string_view sign) { return is_sign(sign); });
    if (comparison == k_comparisons.end()) {
      const Ends ends = range(dimension);
      in.low = ends.low;
      in.high = ends.high;
      return {in};
    }
    ++at_;
    if (next().kind != Token::Kind::number) fail("expected a number");
    const double value = tokens_[at_++].number * taken_unit(dimension).value_or(1);
    if (*comparison != "<" && *comparison != "<=") in.low = value;
    if (*comparison != ">" && *comparison != ">=") in.high = value;
    in.is_low_open = *comparison == ">";
    in.is_high_open = *comparison == "<";
    return {in};
  }

  [[noreturn]] void fail_no_number(const std::string& name, std::size_t column) const {
    std::vector<std::string> known;
    std::size_t elements = 0;
    for (const NumberName& number : numbers_) {
      known.push_back(number.name);
      if (number.name.starts_with(name + "[")) ++elements;
    }
    if (elements > 0)
      fail_at(column, fmt::format("'{}' has {} elements; choose one, such as {}", name, elements,
                                  *std::ranges::find_if(known, [&](const std::string& other) {
                                    return other.starts_with(name + "[");
                                  })));
    if (scene_.find(name))
      fail_at(column,
              fmt::format("'{}' is not a number; expected 'in', 'touches' or 'ends in' after it",
                          name));
    const auto other = std::ranges::find(k_other_words, name, &OtherWord::word);
    const bool is_other_word = other != k_other_words.end() && number_called(other->name);
    const auto near =
        is_other_word ? std::optional(std::string(other->name)) : request::nearest(name, known);
    fail_at(column,
            near ? fmt::format("no number is named '{}'; did you mean '{}'?", name, *near)
                 : fmt::format(
                       "no number is named '{}'; to list the numbers, run `sleight find --names`",
                       name));
  }

  // Boxes, ranges and units.

  Box box() {
    Box box;
    std::array<bool, 3> seen{};
    constexpr std::array<std::string_view, 3> k_axes{"x", "y", "z"};
    while (true) {
      const auto axis =
          std::ranges::find_if(k_axes, [&](std::string_view word) { return is_word(word); });
      if (axis == k_axes.end()) break;
      const auto i = static_cast<std::size_t>(axis - k_axes.begin());
      if (seen[i]) fail(fmt::format("{} already has a range", *axis));
      seen[i] = true;
      ++at_;
      const Ends ends = range(Dimension::length);
      box.low_m[static_cast<Eigen::Index>(i)] = ends.low;
      box.high_m[static_cast<Eigen::Index>(i)] = ends.high;
      const bool is_axis_behind = after_next().kind == Token::Kind::word &&
                                  std::ranges::find(k_axes, after_next().text) != k_axes.end();
      if (is_sign(",") && is_axis_behind) ++at_;
    }
    if (!seen[0] && !seen[1] && !seen[2])
      fail("expected a range of x, y or z, such as 'x 0..20mm'");
    return box;
  }

  Stretch during() {
    if (!take_word("during")) return {};
    const Ends ends = range(Dimension::time);
    return {.from_s = ends.low, .to_s = ends.high};
  }

  Ends range(Dimension dimension) {
    const std::size_t column = next().column;
    std::optional<double> low;
    std::optional<double> high;
    std::optional<double> low_unit;
    std::optional<double> high_unit;
    if (next().kind == Token::Kind::number) {
      low = tokens_[at_++].number;
      low_unit = taken_unit(dimension);
    }
    if (!take_sign("..")) fail("expected '..', as in 0..20, 0.. or ..20");
    if (next().kind == Token::Kind::number) {
      high = tokens_[at_++].number;
      high_unit = taken_unit(dimension);
    }
    if (!low && !high) fail_at(column, "a range needs at least one end, as in 0.. or ..20");
    // If only one end has a unit, the unit applies to both ends.
    Ends ends;
    if (low) ends.low = *low * low_unit.value_or(high_unit.value_or(1));
    if (high) ends.high = *high * high_unit.value_or(low_unit.value_or(1));
    if (ends.low > ends.high)
      fail_at(column, "the range is empty, because its first value is above its second value");
    return ends;
  }

  /// Returns the unit's value in SI, or nothing if there is no unit.
  std::optional<double> taken_unit(Dimension dimension) {
    if (next().kind != Token::Kind::word) return std::nullopt;
    const Unit* unit = find_unit(next().text);
    if (unit == nullptr) {
      // A word after a space isn't a unit.
      if (next().is_joined)
        fail(fmt::format("'{}' is not a unit; the units are {}", next().text, units()));
      return std::nullopt;
    }
    if (unit->dimension != dimension)
      fail(fmt::format("expected {} here, but {} is a unit of {}",
                       k_dimension_words[static_cast<std::size_t>(dimension)], unit->name,
                       k_dimension_words[static_cast<std::size_t>(unit->dimension)]));
    ++at_;
    return unit->si;
  }

  static std::string units() {
    std::string names;
    for (const Unit& unit : k_units)
      names += fmt::format("{}{}", names.empty() ? "" : ", ", unit.name);
    return names;
  }

  std::vector<Token> tokens_;
  std::size_t at_ = 0;
  std::size_t depth_ = 0;
  const scene::Scene& scene_;
  const std::vector<NumberName>& numbers_;
};

/// Returns the screen column of a byte in UTF-8 text. Continuation bytes don't count.
std::size_t screen_column(std::string_view text, std::size_t byte) {
  const auto before = text.substr(0, byte);
  return static_cast<std::size_t>(std::ranges::count_if(
      before, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

}  // namespace

base::Result<Condition, QueryError> parse_query(std::string_view text, const scene::Scene& scene,
                                                const std::vector<NumberName>& numbers) {
  auto tokens = tokens_of(text);
  if (!tokens) return tokens.error();
  try {
    return Parser(std::move(tokens).value(), scene, numbers).whole();
  } catch (const Fault& fault) {
    return fault.error;
  }
}

std::string with_mark(const QueryError& error, std::string_view text) {
  // Show only the surroundings of the error in a long text.
  constexpr std::size_t k_shown_about = 60;
  const auto is_inside_sign = [&](std::size_t byte) {
    return byte < text.size() && (static_cast<unsigned char>(text[byte]) & 0xC0U) == 0x80U;
  };
  std::size_t begin = error.column > k_shown_about ? error.column - k_shown_about : 0;
  while (begin > 0 && is_inside_sign(begin))
    --begin;
  std::size_t end = std::min(text.size(), error.column + k_shown_about);
  while (is_inside_sign(end))
    ++end;
  std::string shown(begin > 0 ? "... " : "");
  const std::size_t mark = shown.size() + error.column - begin;
  shown += text.substr(begin, end - begin);
  if (end < text.size()) shown += " ...";
  // Replace control characters, which could affect a terminal.
  std::ranges::replace_if(
      shown, [](char c) { return (c >= 0 && c < ' ') || c == '\x7f'; }, ' ');
  return fmt::format("column {}: {}\n  {}\n  {:>{}}", screen_column(text, error.column) + 1,
                     error.message, shown, "^", screen_column(shown, mark) + 1);
}

}  // namespace sleight::browse
