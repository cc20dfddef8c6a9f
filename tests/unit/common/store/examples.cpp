#include "tests/unit/common/store/examples.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <filesystem>
#include <utility>

#include "common/random/stream.h"
#include "common/store/stored_run.h"
#include "tests/support/numbers.h"

namespace sleight::store::testing {
namespace {

bool same(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

random::Stream stream_of(std::uint32_t chain, std::uint64_t scan, random::Purpose purpose) {
  return random::Stream({.seed = 7, .chain = base::ChainId{chain}, .purpose = purpose}, scan);
}

base::Bytes noise(std::size_t size, random::Stream& stream) {
  base::Bytes bytes(size);
  for (std::byte& byte : bytes)
    byte = static_cast<std::byte>(stream.bits());
  return bytes;
}

}  // namespace

plan::ScanRecord record_of(std::uint32_t chain, std::uint64_t scan) {
  random::Stream stream = stream_of(chain, scan, random::Purpose::prior);
  plan::ScanRecord record;
  record.log_prior = 10 * stream.uniform() - 5;
  record.log_constraint = scan % 4 == 1 ? -k_infinity : -stream.uniform();
  record.satisfied = stream.uniform() < 0.5;
  record.lineage = scan / 10;
  record.proposed = {static_cast<std::uint32_t>(stream.bits()), 1};
  record.accepted = {static_cast<std::uint32_t>(scan), 0};
  const double payload = std::bit_cast<double>(0x7ff8'0000'0000'0000 | (stream.bits() >> 16));
  record.outcome = {stream.uniform(), payload, k_infinity, -k_infinity, 0.0, -0.0};
  if (scan % 5 == 2) record.failures.by_kind = {scan, 0, 1, 0, chain, 0};
  record.overlapping_starts = scan % 7;
  if (scan % 4 != 1) record.method_values = {stream.uniform(), -k_infinity, -0.0};
  if (scan % 3 != 0) record.state = noise(1 + scan % 17, stream);
  return record;
}

base::Bytes state_before(std::uint32_t chain, std::uint64_t scan) {
  if (scan == 0) return {};
  random::Stream stream = stream_of(chain, scan, random::Purpose::proposal);
  return noise(scan % 23, stream);
}

plan::UnitResult result_of(std::uint32_t chain, std::uint64_t first, std::uint32_t scans) {
  plan::UnitResult result{.unit = {.replica = {base::ChainId{chain}, base::ReplicaId{0}},
                                   .first_scan = base::ScanIndex{first},
                                   .scans = scans},
                          .scans = {},
                          .state_after = state_before(chain, first + scans)};
  for (std::uint64_t scan = first; scan < first + scans; ++scan)
    result.scans.push_back(record_of(chain, scan));
  return result;
}

plan::UnitResult forged(plan::UnitResult result) {
  for (plan::ScanRecord& scan : result.scans) {
    scan.log_prior += 1;
    scan.log_constraint = -77;
    scan.satisfied = !scan.satisfied;
    ++scan.lineage;
    scan.proposed = {9};
    scan.accepted = {9};
    scan.outcome = {9};
    scan.failures.by_kind = {9};
    scan.overlapping_starts = 9;
    scan.method_values = {9, 9, 9};
    scan.state = base::Bytes(3, std::byte{9});
  }
  result.state_after = base::Bytes(5, std::byte{9});
  return result;
}

bool same_bits(const plan::ScanRecord& a, const plan::ScanRecord& b) {
  return same(a.log_prior, b.log_prior) && same(a.log_constraint, b.log_constraint) &&
         a.satisfied == b.satisfied && a.lineage == b.lineage &&
         same(a.inverse_temperature, b.inverse_temperature) && a.proposed == b.proposed &&
         a.accepted == b.accepted && a.state == b.state && a.failures == b.failures &&
         a.overlapping_starts == b.overlapping_starts && a.method_values == b.method_values &&
         std::equal(a.outcome.begin(), a.outcome.end(), b.outcome.begin(), b.outcome.end(),
                    [](double x, double y) { return same(x, y); });
}

RunIdentity example_identity(std::uint32_t chains) {
  return {.identity_text = "[world]\nname = \"example\"\n",
          .request_text = "[world]\nname = \"example\"\n[stop]\nscans = 10\n",
          .results_version = "r1",
          .program_version = "1.0",
          .chains = chains};
}

namespace {

std::vector<plan::ScanRecord> draws_of(const StoredRun& run, std::uint32_t chain) {
  std::vector<plan::ScanRecord> records;
  run.for_each_draw(base::ChainId{chain}, [&](base::ScanIndex scan, const auto& record) {
    EXPECT_EQ(scan.value, records.size());
    records.push_back(record);
  });
  return records;
}

void expect_same(const StoredRun& run, RunStore& store, std::uint32_t chain, std::uint64_t scans) {
  SCOPED_TRACE(fmt::format("chain {}, scans {}", chain, scans));
  bool found = false;
  for (const ReplicaProgress& replica : store.progress()) {
    if (replica.replica.chain.value != chain) continue;
    found = true;
    EXPECT_EQ(replica.next_scan, scans);
    EXPECT_EQ(replica.state, state_before(chain, scans));
  }
  EXPECT_EQ(found, scans > 0);

  std::uint64_t next = 0;
  store.replay({base::ChainId{chain}, base::ReplicaId{0}},
               [&](base::ScanIndex first, std::span<const plan::ScanRecord> records) {
                 EXPECT_EQ(first.value, next);
                 for (const plan::ScanRecord& record : records) {
                   const plan::ScanRecord expected = record_of(chain, next++);
                   EXPECT_EQ(record.satisfied, expected.satisfied);
                   EXPECT_EQ(record.lineage, expected.lineage);
                 }
               });
  EXPECT_EQ(next, scans);

  const std::vector<plan::ScanRecord> records = draws_of(run, chain);
  ASSERT_EQ(records.size(), scans);
  for (std::uint64_t scan = 0; scan < scans; ++scan) {
    ASSERT_TRUE(same_bits(records[scan], record_of(chain, scan))) << "scan " << scan;
  }
}

}  // namespace

std::vector<plan::ScanRecord> stored(const std::string& folder, std::uint32_t chain,
                                     std::uint64_t scans) {
  return draws_of(StoredRun(folder, {.chains = chain + 1, .scans = scans}), chain);
}

void expect_stored(const std::string& folder, RunStore& store, std::uint32_t chain,
                   std::uint64_t scans) {
  expect_same(StoredRun(folder, {.chains = chain + 1, .scans = scans}), store, chain, scans);
}

void expect_stored_of(RunStore& store, std::uint32_t chain, std::uint64_t scans) {
  expect_same(StoredRun(store.to_read(), {.chains = chain + 1, .scans = scans}), store, chain,
              scans);
}

RunFolder::RunFolder() : folder_(path("run")) {
  std::filesystem::create_directory(folder_);
}

}  // namespace sleight::store::testing
