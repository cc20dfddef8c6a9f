#include "worker/sampling/search_first.h"

#include <utility>

#include "common/base/check.h"

namespace sleight::sampling {
namespace {

/// The plan after a search that is the whole run.
class NoChains final : public plan::Plan {
  std::optional<plan::Unit> next_unit(std::uint32_t) override { return std::nullopt; }
  void consume(plan::ReplicaKey, base::ScanIndex, std::span<const plan::ScanRecord>) override {
    CHECK(false);
  }
  bool finished() const override { return true; }
  std::uint64_t scans_common() const override { return 0; }
  plan::Finds finds() const override { return {.is_all = true}; }
  std::uint64_t scans_consumed() const override { return 0; }
  /// The number of starts that a search needs isn't known in advance.
  std::optional<std::uint64_t> scans_total() const override { return std::nullopt; }
  bool learns() const override { return false; }
};

}  // namespace

SearchFirst::SearchFirst(SearchLanes lanes, std::unique_ptr<plan::Plan> then)
    : PlanAround(then ? std::move(then) : std::make_unique<NoChains>()), lanes_(std::move(lanes)) {}

std::optional<plan::Unit> SearchFirst::next_unit(std::uint32_t scans_max) {
  if (auto unit = lanes_.next_unit(scans_max)) return unit;
  return plan().next_unit(scans_max);
}

std::optional<plan::Block> SearchFirst::next_block(const plan::BlockLimits& limits) {
  if (auto unit = lanes_.next_unit(limits.unit_scans_max))
    return plan::Block{.members = {*std::move(unit)}};
  return plan().next_block(limits);
}

void SearchFirst::consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
                          std::span<const plan::ScanRecord> records) {
  if (SearchLanes::has(replica.chain)) {
    lanes_.consume(replica.chain, first_scan, records);
  } else {
    plan().consume(replica, first_scan, records);
  }
}

plan::Finds SearchFirst::finds() const {
  plan::Finds finds = lanes_.finds();
  finds.is_all = plan().finds().is_all;
  return finds;
}

std::uint64_t SearchFirst::scans_consumed() const {
  return lanes_.starts() + plan().scans_consumed();
}

std::optional<std::uint64_t> SearchFirst::scans_total() const {
  const auto total = plan().scans_total();
  return total ? std::optional(*total + lanes_.starts()) : std::nullopt;
}

}  // namespace sleight::sampling
