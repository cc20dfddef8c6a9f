// Decides which requests are answered: those of our own page, in an authorized browser.
//
// The attackers are other users of the host, who can reach the port, and pages of other servers in
// the person's browser. Such pages can send requests here, and can use a DNS name that resolves to
// this address. A request passes if all of these conditions hold:
//
// 1. The method is GET, HEAD or POST. There is one Host header, which is exactly one of our hosts
//    (against DNS rebinding).
// 2. The path is plain (target.h). Only a POST has a body. The body's type is
//    application/json, which forms of foreign pages cannot send. Content-Length is given.
//    Chunks are refused, because browsers send none and parsers have disagreed about where chunks
//    end. In Beast 1.74, an assertion in debug builds fails if the last chunk arrives in pieces.
// 3. Origin, if present, is http:// followed by the Host. A POST has an Origin. A stream of events
//    has an Origin or Sec-Fetch-Site: same-origin, because browsers omit Origin in same-origin
//    GETs.
// 4. Sec-Fetch-Site, if present, is same-origin or none. (same-site can be any user's server at
//    another port of this host.)
// 5. The cookie sleight-PORT has the server's secret.
//
// A link with an unused token passes without conditions 4 and 5, and sets the cookie. The request
// must then be a top-level navigation, such as a click on a link in a web mail.
//
// Refusals say what to do, and contain nothing from the request.
//
// Not guarded against: browsers send cookies to all ports of a host. If the person opens another
// user's server at the same host name, that server receives the cookie.
//
// Thread safety: const functions may be called from several threads at once.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "clients/web/ask.h"
#include "clients/web/keys.h"
#include "common/base/result.h"

namespace sleight::web {

/// A header line of a request, without blanks around the value.
struct FieldView {
  std::string_view name{};
  std::string_view value{};
};

struct Head {
  std::string_view method{};
  std::string_view target{};
  unsigned version = 11;  ///< 10: HTTP/1.0
  std::vector<FieldView> fields{};
};

/// Why a request isn't answered.
struct Refusal {
  unsigned status = 400;
  std::string_view error{};
  std::string_view what_to_do{};
  bool is_json = false;  ///< for paths below /api/, which scripts read; else plain text
};

/// How to answer a request that has passed.
enum class Way : std::uint8_t {
  answer,  ///< by a file or the handler
  stream,  ///< a stream of events
  let_in,  ///< 303 to "/" with the cookie
  /// A page with the cookie that redirects to "/", because browsers don't send a Strict cookie on a
  /// redirect that another site started.
  let_in_by_page,
  go_home,  ///< 303 to "/": the browser already has the cookie and doesn't need its token
};

struct Passed {
  Way way = Way::answer;
  Ask ask{};  ///< without its body
  bool is_head = false;
  bool has_body = false;
  bool wants_continue = false;  ///< the client waits for "100 Continue" before sending the body
  std::string if_none_match{};
};

class Guard {
 public:
  struct Options {
    std::uint16_t port = 0;
    std::vector<std::string> hosts{};
    std::string events_path = "/api/events";
    /// What to do without a cookie or with an invalid token; a sentence for people.
    std::string way_in{};
  };
  /// `keys` must outlive the guard.
  Guard(Options options, Keys& keys);

  /// Uses up a token of `keys` if the browser has no cookie.
  base::Result<Passed, Refusal> judge(const Head& head) const;

  /// The value of Set-Cookie for a newly authorized browser.
  std::string cookie() const;

 private:
  /// Facts about the request's sender from Host, Origin and Sec-Fetch-Site.
  struct Origins;
  std::optional<Refusal> judge_origins(const Head& head, Origins& origins) const;
  bool has_cookie(const Head& head) const;

  std::vector<std::string> hosts_;
  std::string events_path_;
  std::string way_in_;
  std::string cookie_name_;
  Keys& keys_;
};

}  // namespace sleight::web
