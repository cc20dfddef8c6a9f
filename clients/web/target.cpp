#include "clients/web/target.h"

#include <algorithm>
#include <utility>

#include "common/request/text.h"

namespace sleight::web {
namespace {

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

bool is_control(char c) {
  return static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
}

/// Decodes a part of the target whose characters were checked.
std::optional<std::string> decode(std::string_view text, bool is_path) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      decoded += !is_path && text[i] == '+' ? ' ' : text[i];
      continue;
    }
    if (text.size() - i < 3) return std::nullopt;
    const int high = hex_digit(text[i + 1]);
    const int low = hex_digit(text[i + 2]);
    if (high < 0 || low < 0) return std::nullopt;
    const char c = static_cast<char>(16 * high + low);
    if (is_control(c) || (is_path && (c == '/' || c == '\\'))) return std::nullopt;
    decoded += c;
    i += 2;
  }
  if (!request::is_utf8(decoded)) return std::nullopt;
  return decoded;
}

bool has_dots_alone(std::string_view path) {
  for (std::size_t begin = 0; begin < path.size();) {
    const std::size_t end = std::min(path.find('/', begin), path.size());
    const std::string_view segment = path.substr(begin, end - begin);
    if (segment == "." || segment == "..") return true;
    begin = end + 1;
  }
  return false;
}

}  // namespace

std::optional<Target> parse_target(std::string_view target) {
  if (target.size() > k_target_bytes_max || !target.starts_with('/')) return std::nullopt;
  const bool is_plain = std::ranges::all_of(
      target, [](char c) { return c > 0x20 && c < 0x7f && c != '\\' && c != '#'; });
  if (!is_plain) return std::nullopt;

  const std::size_t mark = std::min(target.find('?'), target.size());
  auto path = decode(target.substr(0, mark), true);
  if (!path || has_dots_alone(*path)) return std::nullopt;
  Target parsed{.path = std::move(*path)};

  std::string_view rest = target.substr(std::min(mark + 1, target.size()));
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find('&'), rest.size());
    const std::string_view part = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (part.empty()) continue;
    const auto equals = static_cast<std::size_t>(std::ranges::find(part, '=') - part.begin());
    auto name = decode(part.substr(0, equals), false);
    auto value = decode(part.substr(std::min(equals + 1, part.size())), false);
    if (!name || !value) return std::nullopt;
    parsed.parameters.push_back({.name = std::move(*name), .value = std::move(*value)});
  }
  return parsed;
}

}  // namespace sleight::web
