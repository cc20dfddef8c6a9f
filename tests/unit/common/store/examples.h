// Results for store tests. A record depends only on its address, so tests can check a store's
// results without a copy of them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/plan/unit.h"
#include "common/store/run_store.h"
#include "tests/unit/common/archive/hdf5/scratch.h"

namespace sleight::store::testing {

/// Returns the record of a scan. Every field depends on the address. Outcomes contain NaNs with
/// payloads, infinities and zeros of both signs. A third of the states are empty.
plan::ScanRecord record_of(std::uint32_t chain, std::uint64_t scan);

base::Bytes state_before(std::uint32_t chain, std::uint64_t scan);

/// Returns the result of scans [first, first + scans) of a chain.
plan::UnitResult result_of(std::uint32_t chain, std::uint64_t first, std::uint32_t scans);

/// Returns a copy of `result`, but with another state and other values in every field of every
/// record.
plan::UnitResult forged(plan::UnitResult result);

bool same_bits(const plan::ScanRecord& a, const plan::ScanRecord& b);

RunIdentity example_identity(std::uint32_t chains);

/// Reads the first `scans` records of a chain, as an archive would read them.
std::vector<plan::ScanRecord> stored(const std::string& folder, std::uint32_t chain,
                                     std::uint64_t scans);

/// Checks that a chain's progress is `scans`, and that its stored records equal record_of() for
/// scans 0 .. scans-1.
void expect_stored(const std::string& folder, RunStore& store, std::uint32_t chain,
                   std::uint64_t scans);

/// Like expect_stored(), but reads through `store`: on a network disk, only the writer may read.
void expect_stored_of(RunStore& store, std::uint32_t chain, std::uint64_t scans);

/// A scratch folder that contains an unlocked run folder.
class RunFolder : public archive::testing::Scratch {
 protected:
  RunFolder();
  const std::string& folder() const { return folder_; }

 private:
  std::string folder_;
};

}  // namespace sleight::store::testing
