// Reads numbers from an archive's request text.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/request/document.h"

namespace sleight::analysis {

class RequestNumbers {
 public:
  /// Throws base::Error(bad_archive) if the text isn't a request.
  RequestNumbers(std::string_view request_text, std::string_view archive);

  /// Returns nothing if there is no such number.
  std::optional<double> find(std::string_view section, std::string_view key) const;

  /// Throws base::Error(bad_archive) if there is no such number.
  double at(std::string_view section, std::string_view key) const;

 private:
  request::Document document_;
  std::string archive_;
};

/// Returns "iteration" if a scan has one iteration, otherwise "scan".
std::string scan_label(const RequestNumbers& numbers);

}  // namespace sleight::analysis
