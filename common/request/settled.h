// Helper for a world's serve_best. serve_best chooses a request's sampler (direction_request.h).
// Each function sets a value and adds it to the normalised text. Not thread-safe.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <string_view>

#include "common/request/binder.h"
#include "common/request/direction_request.h"
#include "common/request/text.h"

namespace sleight::request {

class Settled {
 public:
  /// REQUIRES: the request does not have these keys of [sampler].
  Settled(Binder& sampler, SamplerParameters& parameters)
      : sampler_(sampler), parameters_(parameters) {}

  void method(Method chosen, std::string_view name) {
    parameters_.method = chosen;
    sampler_.settle("method", toml_string(name));
  }
  /// Chains start at a search's finds.
  void search() {
    parameters_.start = Start::search;
    sampler_.settle("start", toml_string("search"));
  }
  void chains(std::uint32_t chains, std::uint32_t round_scans, std::uint32_t iterations_per_scan) {
    count("chains", parameters_.chains, chains);
    count("round_scans", parameters_.round_scans, round_scans);
    count("iterations_per_scan", parameters_.iterations_per_scan, iterations_per_scan);
  }
  /// Chains relax a search's finds.
  void relax(std::uint32_t iterations_per_scan, std::uint32_t relax_scans) {
    count("iterations_per_scan", parameters_.iterations_per_scan, iterations_per_scan);
    count("relax_scans", parameters_.relax_scans, relax_scans);
  }
  /// `value`: a count or an optional count.
  void count(std::string_view key, auto& value, std::uint32_t chosen) {
    value = chosen;
    sampler_.settle(key, fmt::format("{}", chosen));
  }
  void number(std::string_view key, double& value, double chosen) {
    value = chosen;
    sampler_.settle(key, toml_number(chosen));
  }

 private:
  Binder& sampler_;
  SamplerParameters& parameters_;
};

}  // namespace sleight::request
