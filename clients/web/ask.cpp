#include "clients/web/ask.h"

#include <algorithm>

#include "common/json/value.h"

namespace sleight::web {

std::optional<std::string_view> Ask::parameter(std::string_view name) const {
  const auto found = std::ranges::find(parameters, name, &Parameter::name);
  if (found == parameters.end()) return std::nullopt;
  return found->value;
}

Content::Content(std::shared_ptr<const std::string> text) : view_(std::as_bytes(std::span(*text))) {
  held_ = std::move(text);
}

Content::Content(std::shared_ptr<const base::Bytes> bytes) : view_(*bytes) {
  held_ = std::move(bytes);
}

std::string_view Content::text() const {
  return {reinterpret_cast<const char*>(view_.data()), view_.size()};
}

Answer error_answer(unsigned status, std::string_view error, std::string_view what_to_do) {
  // Puts "error" first, because people read it first.
  json::Value json;
  json["error"] = error;
  json["what_to_do"] = what_to_do;
  return {.status = status, .content = json.dump() + "\n"};
}

}  // namespace sleight::web
