#include "common/request/diagnostic.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "common/request/text.h"

namespace sleight::request {
namespace {
constexpr std::size_t k_file_name_characters_max = 4096;
}

std::string to_string(const Diagnostic& diagnostic) {
  if (diagnostic.place.line == 0) return fmt::format("{}: {}", diagnostic.file, diagnostic.message);
  return fmt::format("{}:{}:{}: {}", diagnostic.file, diagnostic.place.line,
                     diagnostic.place.column, diagnostic.message);
}

Diagnostics::Diagnostics(std::string_view file)
    : file_(printable(file, k_file_name_characters_max)) {}

void Diagnostics::add(Place place, std::string message) {
  found_.push_back({file_, place, std::move(message)});
}

std::vector<Diagnostic> Diagnostics::sorted() const {
  std::vector<Diagnostic> all = found_;
  std::stable_sort(all.begin(), all.end(),
                   [](const Diagnostic& a, const Diagnostic& b) { return a.place < b.place; });
  if (all.size() > k_diagnostics_max) {
    const std::size_t hidden = all.size() - k_diagnostics_max;
    const Place place = all[k_diagnostics_max].place;
    all.resize(k_diagnostics_max);
    all.push_back({file_, place, fmt::format("{} more errors are not shown", hidden)});
  }
  return all;
}

}  // namespace sleight::request
