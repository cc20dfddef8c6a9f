#include "clients/plot/text.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "common/request/text.h"

namespace sleight::plot {

namespace {

constexpr std::string_view k_replacement = "\uFFFD";
constexpr std::string_view k_ellipsis = "…";

// Advance widths of DejaVu Sans for the characters from ' ' to '~', in thousandths of the size.
constexpr std::array<std::uint16_t, 95> k_advance = {
    317, 400, 459, 837, 636, 950, 779, 274, 390, 390, 500, 837, 317, 360,  317, 336, 636, 636, 636,
    636, 636, 636, 636, 636, 636, 636, 336, 336, 837, 837, 837, 530, 1000, 684, 686, 698, 770, 631,
    575, 774, 751, 294, 294, 655, 557, 862, 748, 787, 603, 787, 694, 634,  610, 731, 684, 988, 685,
    610, 685, 390, 336, 390, 837, 500, 500, 612, 634, 549, 634, 615, 352,  634, 633, 277, 277, 579,
    277, 974, 633, 611, 634, 634, 411, 520, 392, 633, 591, 817, 591, 591,  524, 636, 336, 636, 837};
constexpr double k_advance_other = 0.84;
constexpr double k_bold = 1.12;  // DejaVu Sans Bold against the normal weight, on average

bool is_continuation(char c) {
  return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U;
}

}  // namespace

std::string printable(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const auto c = request::front_code_point(text);
    const char32_t value = c ? c->value : 0;
    const bool is_control = value < 0x20 || (value >= 0x7F && value < 0xA0);
    // XML forbids these two values.
    const bool is_forbidden = value == 0xFFFE || value == 0xFFFF;
    const std::size_t bytes = c && !is_forbidden ? c->bytes : 1;
    if (value == '\t' || value == '\n' || value == '\r') {
      out += ' ';
    } else if (is_control || is_forbidden) {
      out += k_replacement;
    } else {
      out += text.substr(0, bytes);
    }
    text.remove_prefix(bytes);
  }
  return out;
}

std::size_t length_of(std::string_view text) {
  return text.size() - static_cast<std::size_t>(std::ranges::count_if(text, is_continuation));
}

std::string_view first_of(std::string_view text, std::size_t count) {
  std::size_t end = 0;
  while (end < text.size() && (count > 0 || is_continuation(text[end]))) {
    if (!is_continuation(text[end])) --count;
    ++end;
  }
  return text.substr(0, end);
}

double text_width_px(std::string_view text, double size_px, Weight weight) {
  double ems = 0;
  for (const char c : text) {
    if (is_continuation(c)) continue;
    ems += c >= ' ' && c <= '~' ? k_advance[static_cast<std::size_t>(c - ' ')] / 1000.0
                                : k_advance_other;
  }
  return ems * size_px * (weight == Weight::bold ? k_bold : 1);
}

std::string fitted(std::string_view text, double size_px, double width_px, Weight weight) {
  if (text_width_px(text, size_px, weight) <= width_px) return std::string(text);
  for (std::size_t count = length_of(text); count-- > 1;) {
    const std::string shorter = std::string(first_of(text, count)) + std::string(k_ellipsis);
    if (text_width_px(shorter, size_px, weight) <= width_px) return shorter;
  }
  return std::string(k_ellipsis);
}

std::string xml_escaped(std::string_view text) {
  static constexpr std::pair<char, std::string_view> k_escapes[] = {
      {'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}, {'\'', "&#39;"}};
  std::string out;
  for (const char c : text) {
    const auto* escape = std::ranges::find(k_escapes, c, &std::pair<char, std::string_view>::first);
    if (escape == std::end(k_escapes)) {
      out += c;
    } else {
      out += escape->second;
    }
  }
  return out;
}

std::string to_ascii(std::string_view text) {
  static constexpr std::pair<std::string_view, std::string_view> k_nearest[] = {
      {"−", "-"},     {"×", "x"},  {"±", "+-"},     {"·", "."},     {"…", "..."},   {"°", "deg"},
      {"≤", "<="},    {"≥", ">="}, {"√", "sqrt "},  {"∞", "inf"},   {"α", "alpha"}, {"β", "beta"},
      {"σ", "sigma"}, {"μ", "mu"}, {"λ", "lambda"}, {"θ", "theta"}, {"π", "pi"},    {"–", "-"},
      {"—", "-"},     {"⁻", "-"},  {"⁰", "0"},      {"¹", "1"},     {"²", "2"},     {"³", "3"},
      {"⁴", "4"},     {"⁵", "5"},  {"⁶", "6"},      {"⁷", "7"},     {"⁸", "8"},     {"⁹", "9"},
  };
  std::string out;
  while (!text.empty()) {
    // ASCII has no raised digits, so write powers of ten as in 1.5e6.
    constexpr std::string_view k_power = "×10";
    if (text.starts_with(k_power) && text.size() > k_power.size()) {
      out += 'e';
      text.remove_prefix(k_power.size());
      continue;
    }
    const std::string_view character = first_of(text, 1);
    const auto* nearest = std::ranges::find(k_nearest, character,
                                            &std::pair<std::string_view, std::string_view>::first);
    if (character.size() == 1) {
      out += character;
    } else {
      out += nearest != std::end(k_nearest) ? nearest->second : "?";
    }
    text.remove_prefix(character.size());
  }
  return out;
}

}  // namespace sleight::plot
