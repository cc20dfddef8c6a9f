// Helper for a world's serve_best. serve_best chooses a request's sampler (direction_request.h).
// Each function sets a value and adds it to the normalised text. Not thread-safe.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <optional>
#include <string_view>

#include "common/request/binder.h"
#include "common/request/direction_request.h"
#include "common/request/text.h"

namespace sleight::request {

class Settled {
 public:
  /// REQUIRES: the request does not have these keys of [sampler].
  explicit Settled(Binder& sampler) : sampler_(sampler) {}

  void word(std::string_view key, std::string_view chosen) {
    sampler_.settle(key, toml_string(chosen));
  }
  void count(std::string_view key, std::uint32_t& value, std::uint32_t chosen) {
    value = chosen;
    sampler_.settle(key, fmt::format("{}", chosen));
  }
  void count(std::string_view key, std::optional<std::uint32_t>& value, std::uint32_t chosen) {
    value = chosen;
    sampler_.settle(key, fmt::format("{}", chosen));
  }
  void number(std::string_view key, double& value, double chosen) {
    value = chosen;
    sampler_.settle(key, toml_number(chosen));
  }

 private:
  Binder& sampler_;
};

}  // namespace sleight::request
