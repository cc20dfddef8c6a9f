// A run's results as an archive is derived from them: complete up to one common scan, in logical
// order. The run store gives one; tests give theirs.
#pragma once

#include <cstdint>
#include <functional>

#include "common/plan/unit.h"

namespace sleight::archive {

class RunView {
 public:
  virtual ~RunView() = default;
  virtual std::uint32_t chains() const = 0;
  /// Scans 0 .. scans()-1 are present for every chain: the cut.
  virtual std::uint64_t scans() const = 0;
  /// Calls `visit` for scans 0 .. scans()-1 of one chain's replica at inverse temperature 1.
  virtual void for_each_scan(
      base::ChainId chain,
      const std::function<void(base::ScanIndex, const plan::ScanRecord&)>& visit) const = 0;
};

}  // namespace sleight::archive
