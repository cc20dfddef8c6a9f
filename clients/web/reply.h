// An answer as bytes to send: its head as text, and its content.
//
// Every answer has these restrictions: the page may run only its own scripts and connect only to
// this server; browsers don't guess types, send no referrer, and don't share the answer with other
// origins. Every answer states how long it may be cached. No answer names the server software or
// repeats the request.
//
// Thread safety: values and pure functions.
#pragma once

#include <string>
#include <string_view>

#include "clients/web/ask.h"
#include "clients/web/guard.h"

namespace sleight::web {

struct Reply {
  Answer answer{};
  bool is_head = false;     ///< the content isn't sent
  bool keeps_open = false;  ///< the connection stays open for another request
};

/// Returns the head with Content-Length, except for a stream of events. REQUIRES: is_sound().
std::string head_text(const Reply& reply);
std::string stream_head_text();

/// The content to send.
base::BytesView content_of(const Reply& reply);

/// Whether an answer can be sent: its status is 200 to 599 but not 204, and its header lines have
/// no control characters.
bool is_sound(const Answer& answer);

Answer answer_of(const Refusal& refusal);
/// Returns the answer that authorizes a browser: 303, or a page that redirects to "/".
Answer answer_of(Way way, const std::string& cookie);
/// Changes the answer to 304 if If-None-Match contains its etag.
Answer unless_known(Answer answer, std::string_view if_none_match);

/// Formats an event for a stream. REQUIRES: `name` has no control characters.
std::string event_text(std::string_view name, std::string_view data);

}  // namespace sleight::web
