// What a page asks of this server and what it is answered, as values.
//
// An Ask has passed the guard (guard.h): it comes from a page of ours, in a browser that was let
// in. What it asks for is still anybody's text: a path is looked up, never opened.
//
// Thread safety: values. Content is shared between copies and never changes.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/bytes.h"

namespace sleight::web {

enum class Method : std::uint8_t {
  get,  ///< HEAD too, of which the server sends the head alone
  post,
};

/// `name=value` of what stands behind the question mark.
struct Parameter {
  std::string name{};
  std::string value{};
};

struct Ask {
  Method method = Method::get;
  /// Percent signs decoded, once: begins with '/', valid UTF-8 without control characters,
  /// backslashes and segments "." and "..".
  std::string path = "/";
  std::vector<Parameter> parameters{};  ///< in their order, decoded likewise
  std::string body{};                   ///< of POST: its type is application/json, its text unread
  bool accepts_gzip = false;

  /// The first parameter of this name.
  std::optional<std::string_view> parameter(std::string_view name) const;
};

/// Bytes of an answer, shared and not copied.
class Content {
 public:
  Content() = default;
  Content(std::string text) : Content(std::make_shared<const std::string>(std::move(text))) {}
  Content(const char* text) : Content(std::string(text)) {}
  Content(base::Bytes bytes) : Content(std::make_shared<const base::Bytes>(std::move(bytes))) {}
  Content(std::shared_ptr<const std::string> text);
  Content(std::shared_ptr<const base::Bytes> bytes);

  base::BytesView view() const { return view_; }
  /// As text, of whatever kind it was made.
  std::string_view text() const;

 private:
  std::shared_ptr<const void> held_;
  base::BytesView view_;
};

/// How long a browser may keep an answer.
enum class Cache : std::uint8_t {
  no_store,   ///< not at all
  immutable,  ///< a year: another content has another name
};

/// A line of an answer's head. No control characters in either.
struct Field {
  std::string name{};
  std::string value{};
};

struct Answer {
  unsigned status = 200;  ///< 200 to 599, and not 204
  std::string type = "application/json";
  Content content{};
  Cache cache = Cache::no_store;
  /// Quoted, as in `"3f2a"`; empty: none. Whoever has this content already is answered 304.
  std::string etag{};
  /// Beyond those that every answer has (reply.h), as Content-Disposition.
  std::vector<Field> fields{};
};

/// {"error": ..., "what_to_do": ...}: two sentences, for people.
Answer error_answer(unsigned status, std::string_view error, std::string_view what_to_do);

}  // namespace sleight::web
