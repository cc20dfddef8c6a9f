#include <array>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "tests/browse/slow_query.h"

namespace sleight::browse::testing {
namespace {

/// Returns any name in quotes.
std::string in_quotes(std::string_view name) {
  std::string text = "\"";
  for (const char sign : name) {
    if (sign == '"' || sign == '\\') text += '\\';
    text += sign;
  }
  return text + "\"";
}

/// Writes "0.1..0.2" or "..0.2". If the range has no ends, writes a low end that is below all
/// values.
std::string range(double low, double high) {
  const bool is_open = !std::isfinite(low) && !std::isfinite(high);
  const auto end = [](double value) {
    return std::isfinite(value) ? fmt::format("{:.17g}", value) : std::string();
  };
  return is_open ? "-1e300.." : end(low) + ".." + end(high);
}

struct Writer {
  const Index& index;

  std::string who(const Bodies& bodies) const {
    if (bodies.is_every) return "every";
    if (bodies.bodies.size() == 1)
      return in_quotes(index.scene.features[bodies.bodies.front()].name);
    return "any";
  }

  static std::string box(const Box& box) {
    constexpr std::array k_axes{'x', 'y', 'z'};
    std::string text;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const bool is_needed = std::isfinite(box.low_m[axis]) || std::isfinite(box.high_m[axis]);
      if (is_needed || (axis == 2 && text.empty()))
        text += fmt::format(" {} {}", k_axes.at(static_cast<std::size_t>(axis)),
                            range(box.low_m[axis], box.high_m[axis]));
    }
    return text;
  }

  static std::string during(const Stretch& when) {
    if (!std::isfinite(when.from_s) && !std::isfinite(when.to_s)) return "";
    return " during " + range(when.from_s, when.to_s);
  }

  std::string joined(const std::vector<Condition>& parts, std::string_view between,
                     bool has_brackets) {
    std::string text;
    for (const Condition& part : parts) {
      const std::string one = std::visit(*this, part.is);
      text += (text.empty() ? "" : std::string(between)) + (has_brackets ? "(" + one + ")" : one);
    }
    return text;
  }

  std::string operator()(const Inside& inside) {
    return who(inside.who) + " in" + box(inside.box) + during(inside.when);
  }
  std::string operator()(const Touches& touches) {
    std::string partner = "any";
    if (!touches.partners.empty()) {
      const scene::Feature& feature = index.scene.features[touches.partners.front()];
      partner = in_quotes(feature.name);
    }
    return who(touches.who) + " touches " + partner + during(touches.when);
  }
  std::string operator()(const EndsIn& ends) { return who(ends.who) + " ends in" + box(ends.box); }
  std::string operator()(const NumberIn& in) {
    const std::string& name = index.numbers[in.number].name;
    if (!in.is_low_open && !in.is_high_open) return name + " " + range(in.low, in.high);
    const auto side = [&](const char* open, const char* closed, bool is_open, double value) {
      const double shown = std::isfinite(value) ? value : std::copysign(1e300, value);
      return fmt::format("{} {} {:.17g}", name, is_open ? open : closed, shown);
    };
    return side(">", ">=", in.is_low_open, in.low) + " and " +
           side("<", "<=", in.is_high_open, in.high);
  }
  std::string operator()(const InOrder& order) { return joined(order.steps, " then ", false); }
  std::string operator()(const AllOf& all) { return joined(all.parts, " and ", true); }
  std::string operator()(const AnyOf& any) { return joined(any.parts, " or ", true); }
  std::string operator()(const Not& no) { return "not (" + joined(no.part, "", false) + ")"; }
};

bool names_a_goal(const Condition& condition, const scene::Scene& scene) {
  const auto any_of = [&](const std::vector<Condition>& parts) {
    for (const Condition& part : parts) {
      if (names_a_goal(part, scene)) return true;
    }
    return false;
  };
  if (const auto* touches = std::get_if<Touches>(&condition.is)) {
    return !touches->partners.empty() &&
           scene.features[touches->partners.front()].kind == scene::FeatureKind::wanted;
  }
  if (const auto* order = std::get_if<InOrder>(&condition.is)) return any_of(order->steps);
  if (const auto* all = std::get_if<AllOf>(&condition.is)) return any_of(all->parts);
  if (const auto* any = std::get_if<AnyOf>(&condition.is)) return any_of(any->parts);
  if (const auto* no = std::get_if<Not>(&condition.is)) return any_of(no->part);
  return false;
}

}  // namespace

std::optional<std::string> text_of(const Condition& condition, const Index& index) {
  if (names_a_goal(condition, index.scene)) return std::nullopt;
  Writer writer{index};
  return std::visit(writer, condition.is);
}

}  // namespace sleight::browse::testing
