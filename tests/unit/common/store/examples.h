// Results for store tests. A record is a function of its address alone, so that tests can check
// what a store returns without remembering what they stored.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/plan/unit.h"
#include "common/store/run_store.h"
#include "tests/unit/common/archive/hdf5/scratch.h"

namespace sleight::store::testing {

/// Returns the record of a scan. Every field varies with the address; outcomes hold NaNs with
/// payloads, infinities and zeros of both signs; a third of the states are empty.
plan::ScanRecord record_of(std::uint32_t chain, std::uint64_t scan);

base::Bytes state_before(std::uint32_t chain, std::uint64_t scan);

/// Returns the result of scans [first, first + scans) of a chain.
plan::UnitResult result_of(std::uint32_t chain, std::uint64_t first, std::uint32_t scans);

/// Returns a copy of `result` in which the state and every field of every record differ.
plan::UnitResult forged(plan::UnitResult result);

bool same_bits(const plan::ScanRecord& a, const plan::ScanRecord& b);

RunIdentity example_identity(std::uint32_t chains);

/// Returns the first `scans` records of a chain, as an archive would read them.
std::vector<plan::ScanRecord> stored(const std::string& folder, std::uint32_t chain,
                                     std::uint64_t scans);

/// Checks that a chain's stored records equal record_of() for scans 0 .. scans-1, and that the
/// chain's progress matches.
void expect_stored(const std::string& folder, RunStore& store, std::uint32_t chain,
                   std::uint64_t scans);

/// Does the checks of expect_stored() for a store that only its writer may read, as on a network
/// disk.
void expect_stored_of(RunStore& store, std::uint32_t chain, std::uint64_t scans);

/// A scratch folder with an unlocked run folder in it.
class RunFolder : public archive::testing::Scratch {
 protected:
  RunFolder();
  const std::string& folder() const { return folder_; }

 private:
  std::string folder_;
};

}  // namespace sleight::store::testing
