#include "clients/web/guard.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <utility>

#include "clients/web/target.h"

namespace sleight::web {
namespace {

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

bool is_equal_but_for_case(std::string_view a, std::string_view b) {
  return std::ranges::equal(a, b, {}, lower, lower);
}

std::string_view without_blanks(std::string_view text) {
  const std::size_t begin = std::min(text.find_first_not_of(" \t"), text.size());
  text.remove_prefix(begin);
  return text.substr(0, text.find_last_not_of(" \t") + 1);
}

/// How often a header occurs, and its first value.
struct Said {
  std::size_t count = 0;
  std::string_view value{};
};

Said said(const Head& head, std::string_view name) {
  Said found;
  for (const FieldView& field : head.fields) {
    if (is_equal_but_for_case(field.name, name) && ++found.count == 1) found.value = field.value;
  }
  return found;
}

/// The parameters of the list entry with this name, such as ";q=0.5" of "gzip;q=0.5, br"; none if
/// absent.
std::optional<std::string_view> in_list(std::string_view list, std::string_view name) {
  while (!list.empty()) {
    const std::size_t end = std::min(list.find(','), list.size());
    const std::string_view part = without_blanks(list.substr(0, end));
    list.remove_prefix(std::min(end + 1, list.size()));
    const std::size_t name_end = std::min(part.find(';'), part.size());
    if (is_equal_but_for_case(without_blanks(part.substr(0, name_end)), name))
      return part.substr(name_end);
  }
  return std::nullopt;
}

bool accepts_gzip(const Head& head) {
  const auto weight = in_list(said(head, "accept-encoding").value, "gzip");
  if (!weight) return false;
  // q=0, q=0.0 and the like mean "not accepted".
  const std::size_t equals = weight->find('=');
  return equals == std::string_view::npos ||
         weight->find_first_of("123456789", equals) != std::string_view::npos;
}

bool is_json_type(std::string_view type) {
  return is_equal_but_for_case(without_blanks(type.substr(0, type.find(';'))), "application/json");
}

/// Checks the request's body length and that unique headers occur only once.
std::optional<Refusal> judge_form(const Head& head, Passed& passed) {
  constexpr std::string_view k_again = "Reload the page.";
  for (const std::string_view once :
       {"content-length", "transfer-encoding", "expect", "origin", "cookie", "sec-fetch-site",
        "sec-fetch-mode", "sec-fetch-dest", "content-type", "accept-encoding"}) {
    if (said(head, once).count > 1)
      return Refusal{400, "The request repeats a header that must be unique.", k_again};
  }
  // Require a single explicit length, so that two parsers cannot disagree about where the body
  // ends.
  const Said length = said(head, "content-length");
  const Said coding = said(head, "transfer-encoding");
  const bool is_number =
      !length.value.empty() && length.value.size() < 19 &&
      std::ranges::all_of(length.value, [](char c) { return c >= '0' && c <= '9'; });
  if (length.count > 0 && (!is_number || coding.count > 0))
    return Refusal{400, "The request's Content-Length is invalid.", k_again};
  if (coding.count > 0)
    return Refusal{411, "This server requires a Content-Length.",
                   "Send Content-Length instead of chunks."};
  passed.has_body = length.value.find_first_not_of('0') != std::string_view::npos;
  if (passed.has_body && passed.ask.method != Method::post)
    return Refusal{400, "Only a POST may have content.", k_again};
  const Said expect = said(head, "expect");
  if (expect.count > 0 && !is_equal_but_for_case(expect.value, "100-continue"))
    return Refusal{417, "This server doesn't support the request's Expect header.", k_again};
  passed.wants_continue = expect.count > 0 && head.version >= 11 && passed.has_body;
  return std::nullopt;
}

}  // namespace

Guard::Guard(Options options, Keys& keys)
    : hosts_(std::move(options.hosts)),
      events_path_(std::move(options.events_path)),
      way_in_(std::move(options.way_in)),
      cookie_name_(fmt::format("sleight-{}", options.port)),
      keys_(keys) {
  for (const std::string_view name : {"127.0.0.1", "localhost"})
    hosts_.push_back(fmt::format("{}:{}", name, options.port));
}

struct Guard::Origins {
  bool has_origin = false;  ///< an Origin is present (and is ours)
  /// Whether Sec-Fetch-Site is absent, same-origin or none, so the request is from our own page or
  /// directly from the person.
  bool is_from_here = true;
  bool says_same_origin = false;
};

std::optional<Refusal> Guard::judge_origins(const Head& head, Origins& origins) const {
  const Said host = said(head, "host");
  if (host.count != 1)
    return Refusal{400, "The request must have exactly one Host header.",
                   "Use a current browser, or curl."};
  if (std::ranges::find(hosts_, host.value) == hosts_.end()) {
    return Refusal{421, "This server has another name.",
                   "Open 127.0.0.1 or localhost with the server's port."};
  }
  const Refusal foreign{403, "A page of another server sent this request.",
                        "Close that page, and open this server's own link."};
  const Said origin = said(head, "origin");
  constexpr std::string_view k_scheme = "http://";
  origins.has_origin = origin.count > 0;
  if (origins.has_origin &&
      (!origin.value.starts_with(k_scheme) || origin.value.substr(k_scheme.size()) != host.value)) {
    return foreign;
  }
  const Said site = said(head, "sec-fetch-site");
  origins.says_same_origin = site.count > 0 && site.value == "same-origin";
  origins.is_from_here = site.count == 0 || origins.says_same_origin || site.value == "none";
  const bool is_navigation = head.method == "GET" &&
                             said(head, "sec-fetch-mode").value == "navigate" &&
                             said(head, "sec-fetch-dest").value == "document";
  if (!origins.is_from_here && !is_navigation) return foreign;
  return std::nullopt;
}

bool Guard::has_cookie(const Head& head) const {
  std::string_view cookies = said(head, "cookie").value;
  bool is_ours = false;
  while (!cookies.empty()) {
    const std::size_t end = std::min(cookies.find(';'), cookies.size());
    const std::string_view cookie = without_blanks(cookies.substr(0, end));
    cookies.remove_prefix(std::min(end + 1, cookies.size()));
    const std::size_t equals = std::min(cookie.find('='), cookie.size());
    // Several cookies may have this name, because pages at other ports can add some.
    if (cookie.substr(0, equals) != cookie_name_) continue;
    is_ours =
        is_same(cookie.substr(std::min(equals + 1, cookie.size())), keys_.secret()) || is_ours;
  }
  return is_ours;
}

std::string Guard::cookie() const {
  return fmt::format("{}={}; HttpOnly; SameSite=Strict; Path=/", cookie_name_, keys_.secret());
}

base::Result<Passed, Refusal> Guard::judge(const Head& head) const {
  const auto judged = [&]() -> base::Result<Passed, Refusal> {
    Passed passed;
    passed.is_head = head.method == "HEAD";
    if (head.method == "POST") {
      passed.ask.method = Method::post;
    } else if (head.method != "GET" && !passed.is_head) {
      return Refusal{405, "The method must be GET, HEAD or POST.", "Use one of these."};
    }
    auto target = parse_target(head.target);
    if (!target)
      return Refusal{400, "The address has invalid characters or parts.", "Correct the address."};
    passed.ask.path = std::move(target->path);
    passed.ask.parameters = std::move(target->parameters);
    if (const auto refusal = judge_form(head, passed)) return *refusal;

    Origins origins;
    if (const auto refusal = judge_origins(head, origins)) return *refusal;
    passed.ask.accepts_gzip = accepts_gzip(head);
    passed.if_none_match = said(head, "if-none-match").value;

    const bool is_let_in = has_cookie(head);
    const Refusal outside{403, "This browser is not authorized, or the link was already used.",
                          way_in_};
    const auto token = passed.ask.parameter("token");
    if (head.method == "GET" && passed.ask.path == "/" && token) {
      // A browser with the cookie doesn't use up the token.
      if (!is_let_in && !keys_.use(*token)) return outside;
      passed.way = !origins.is_from_here ? Way::let_in_by_page
                   : is_let_in           ? Way::go_home
                                         : Way::let_in;
      return passed;
    }
    if (!origins.is_from_here) {
      return Refusal{403, "A page of another server opened this address.",
                     "To open this page directly, click the address bar and press Enter."};
    }
    if (!is_let_in) return outside;

    const bool is_stream = passed.ask.path == events_path_;
    if (passed.ask.method == Method::post) {
      if (!origins.has_origin)
        return Refusal{403, "A POST must have an Origin header.",
                       "Add an Origin header, as browsers do."};
      if (!is_json_type(said(head, "content-type").value))
        return Refusal{415, "Content must be application/json.",
                       "Send Content-Type: application/json."};
      if (is_stream) return Refusal{405, "Events can only be read.", "Use GET."};
    } else if (is_stream) {
      if (!origins.has_origin && !origins.says_same_origin)
        return Refusal{403, "Reading events requires an Origin header.", "Add an Origin header."};
      passed.way = Way::stream;
    }
    return passed;
  }();
  if (judged) return judged;
  Refusal refusal = judged.error();
  refusal.is_json = head.target.starts_with("/api/");
  return refusal;
}

}  // namespace sleight::web
