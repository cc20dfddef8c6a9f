// Refusal of a page's request: an HTTP status and two sentences.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>

namespace sleight::gallery {

inline constexpr unsigned k_bad_request = 400;
inline constexpr unsigned k_not_found = 404;
inline constexpr unsigned k_damaged = 502;

class Refused : public std::runtime_error {
 public:
  Refused(unsigned status, const std::string& error, std::string what_to_do)
      : std::runtime_error(error), status_(status), what_to_do_(std::move(what_to_do)) {}
  unsigned status() const { return status_; }
  const std::string& what_to_do() const { return what_to_do_; }

 private:
  unsigned status_;
  std::string what_to_do_;
};

class Gallery;
/// Throws Refused with the reason why an existing archive has no snapshot or only an outline.
[[noreturn]] void refuse_unread(const Gallery& gallery, std::size_t archive);

}  // namespace sleight::gallery
