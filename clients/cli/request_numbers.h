// Numbers out of the request text that an archive carries, for pictures that show what was asked.
#pragma once

#include <string>
#include <string_view>

#include "common/request/document.h"

namespace sleight::cli {

class RequestNumbers {
 public:
  /// Throws base::Error(bad_archive) when the text is no request.
  RequestNumbers(std::string_view request_text, std::string_view archive);

  /// Throws base::Error(bad_archive) when there is no such number.
  double at(std::string_view section, std::string_view key) const;

 private:
  request::Document document_;
  std::string archive_;
};

}  // namespace sleight::cli
