// An answer as it goes out: a head as text, and content.
//
// Every answer has: a policy by which the page runs its own scripts alone and talks to this server
// alone, no guessing of types, no referrer, no sharing with other origins, and how long it may be
// kept. None says which server this is, or repeats what was asked.
//
// Thread safety: values and pure functions.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "clients/web/ask.h"
#include "clients/web/guard.h"

namespace sleight::web {

struct Reply {
  Answer answer{};
  bool is_head = false;     ///< its content stays here
  bool keeps_open = false;  ///< the connection is for another request
};

/// With lengths, but for a stream of events, which ends with its connection. REQUIRES: is_sound.
std::string head_text(const Reply& reply);
std::string stream_head_text();

/// What is sent of the content.
base::BytesView content_of(const Reply& reply);

/// Whether an answer can be sent: a status of 200 to 599, no control characters in its head's
/// lines.
bool is_sound(const Answer& answer);

Answer answer_of(const Refusal& refusal);
/// Of the ways that let in: 303, or a page that goes on to "/".
Answer answer_of(Way way, const std::string& cookie);
/// What one is sent that may have it already: 304 where If-None-Match names its etag.
Answer unless_known(Answer answer, std::string_view if_none_match);

/// An event as streams have it. REQUIRES: a name without control characters.
std::string event_text(std::string_view name, std::string_view data);

}  // namespace sleight::web
