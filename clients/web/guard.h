// Which requests are answered: those of our own page, in a browser that was let in.
//
// The enemies are other users of the host, who reach the port, and pages of other servers in the
// person's browser, which may send requests here and which DNS may have renamed to this address.
// A request passes if all of this holds:
//   1. It is GET, HEAD or POST, with one Host, exactly one of ours (against rebinding).
//   2. Its path is plain (target.h). Only a POST has a body. Its type is application/json: forms of
//      foreign pages can't send that. It tells its length. Chunks are refused: browsers send none,
//      readers have differed about where they end, and in Beast 1.74 a check fails, which ends a
//      debug build, when the last one comes in small pieces.
//   3. Origin, where present, is http:// and its Host. POST has one. A stream of events has one, or
//      Sec-Fetch-Site: same-origin: browsers leave Origin out of same-origin GETs.
//   4. Sec-Fetch-Site, where present, is same-origin or none. same-site is another port of this
//      host: any user's.
//   5. It has the cookie sleight-PORT with the server's secret.
// A link with an unused token lets in without 4 and 5: it sets the cookie. 4 then allows no more
// than a top-level navigation, as by a link in a message that the person reads in a browser.
//
// Refusals say what to do and repeat nothing of the request.
//
// Not guarded against: a cookie goes to all ports of its host. A person who opens a page of another
// user's server at the same host name gives it the cookie.
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

/// A line of a request's head, as it came but for blanks around the value.
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

/// Why a request is not answered as it asks.
struct Refusal {
  unsigned status = 400;
  std::string_view error{};
  std::string_view what_to_do{};
  bool is_json = false;  ///< below /api/, where scripts read it; else plain text
};

/// What becomes of a request that passes.
enum class Way : std::uint8_t {
  answer,  ///< by a file or the handler
  stream,  ///< of events
  let_in,  ///< 303 to "/" with the cookie
  /// The same by a page that goes on to "/": browsers don't send a Strict cookie on a redirect that
  /// began at another site.
  let_in_by_page,
  go_home,  ///< 303 to "/": it has the cookie already, and a token that isn't needed
};

struct Passed {
  Way way = Way::answer;
  Ask ask{};  ///< without its body
  bool is_head = false;
  bool has_body = false;
  bool wants_continue = false;  ///< waits for "100 Continue" before it sends the body
  std::string if_none_match{};
};

class Guard {
 public:
  struct Options {
    std::uint16_t port = 0;
    std::vector<std::string> hosts{};
    std::string events_path = "/api/events";
    /// A sentence for one that has no cookie, or a token that doesn't hold.
    std::string way_in{};
  };
  /// `keys` must outlive it.
  Guard(Options options, Keys& keys);

  /// May use up a token of `keys`.
  base::Result<Passed, Refusal> judge(const Head& head) const;

  /// The value of Set-Cookie for one that is let in.
  std::string cookie() const;

 private:
  /// What is wrong with Host, Origin or where a browser says that it comes from; `is_ours` is
  /// whether the last allows more than a link that lets in.
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
