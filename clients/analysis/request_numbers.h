// Numbers out of the request text that an archive carries, for pictures that show what was asked.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/request/document.h"

namespace sleight::analysis {

class RequestNumbers {
 public:
  /// Throws base::Error(bad_archive) when the text is no request.
  RequestNumbers(std::string_view request_text, std::string_view archive);

  /// None when there is no such number.
  std::optional<double> find(std::string_view section, std::string_view key) const;

  /// Throws base::Error(bad_archive) when there is no such number.
  double at(std::string_view section, std::string_view key) const;

 private:
  request::Document document_;
  std::string archive_;
};

/// What a step along a chain is called: "iteration" when each scan is one, else "scan".
std::string scan_label(const RequestNumbers& numbers);

}  // namespace sleight::analysis
