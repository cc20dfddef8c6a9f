// A run as it stands in its store, cut at a common scan: what archives are derived from.
//
// Reads through a connection of its own, beside a writer. Thread safety: one thread at a time.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "common/archive/run_view.h"
#include "common/store/database.h"

namespace sleight::store {

class StoredRun final : public archive::RunView {
 public:
  /// REQUIRES: every chain of the store has its first `scans` scans committed.
  StoredRun(const std::string& folder, std::uint32_t chains, std::uint64_t scans);

  std::uint32_t chains() const override { return chains_; }
  std::uint64_t scans() const override { return scans_; }
  void for_each_scan(
      base::ChainId chain,
      const std::function<void(base::ScanIndex, const plan::ScanRecord&)>& visit) const override;

 private:
  mutable Database database_;
  std::uint32_t chains_;
  std::uint64_t scans_;
  std::uint64_t salt_ = 0;
};

}  // namespace sleight::store
