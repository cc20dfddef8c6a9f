// A page's request to this server and the answer, as values.
//
// An Ask has passed the guard (guard.h): it comes from our own page, in an authorized browser. The
// contents of an Ask are still untrusted: a path is looked up, never opened.
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
  get,  ///< or HEAD, for which the server sends no content
  post,
};

/// A `name=value` after the target's question mark.
struct Parameter {
  std::string name{};
  std::string value{};
};

struct Ask {
  Method method = Method::get;
  /// The path after decoding percent signs once. It begins with '/', and is valid UTF-8 without
  /// control characters, backslashes, and segments "." and "..".
  std::string path = "/";
  std::vector<Parameter> parameters{};  ///< in their order, decoded as the path is
  std::string body{};                   ///< of a POST; type application/json, not parsed
  bool accepts_gzip = false;

  std::optional<std::string_view> parameter(std::string_view name) const;
};

/// Bytes of an answer, shared without copies.
class Content {
 public:
  Content() = default;
  Content(std::string text) : Content(std::make_shared<const std::string>(std::move(text))) {}
  Content(const char* text) : Content(std::string(text)) {}
  Content(base::Bytes bytes) : Content(std::make_shared<const base::Bytes>(std::move(bytes))) {}
  Content(std::shared_ptr<const std::string> text);
  Content(std::shared_ptr<const base::Bytes> bytes);

  base::BytesView view() const { return view_; }
  /// The content as text, even if it was created from bytes.
  std::string_view text() const;

 private:
  std::shared_ptr<const void> held_;
  base::BytesView view_;
};

/// How long browsers may store an answer.
enum class Cache : std::uint8_t {
  no_store,   ///< not at all
  immutable,  ///< a year; changed content gets a new name
};

/// A header line of an answer. REQUIRES: no control characters.
struct Field {
  std::string name{};
  std::string value{};
};

struct Answer {
  unsigned status = 200;  ///< 200 to 599, and not 204
  std::string type = "application/json";
  Content content{};
  Cache cache = Cache::no_store;
  /// The ETag with its quotes, such as `"3f2a"`; empty: none. Clients that have this content
  /// receive 304.
  std::string etag{};
  /// Additional headers, such as Content-Disposition (reply.h adds the common ones).
  std::vector<Field> fields{};
};

/// {"error": ..., "what_to_do": ...}: two sentences for people.
Answer error_answer(unsigned status, std::string_view error, std::string_view what_to_do);

}  // namespace sleight::web
