#include "worker/sampling/simulated_tempering.h"

#include <algorithm>
#include <limits>

#include "common/base/check.h"
#include "common/math/elementary.h"
#include "common/random/stream.h"
#include "worker/sampling/temperature_steps.h"

namespace sleight::sampling {

SimulatedTempering::SimulatedTempering(const BurnIn& burn_in)
    : burn_in_(burn_in),
      log_weights_(burn_in.ladder.size(), 0.0),
      scan_(burn_in.scans),
      level_(static_cast<std::uint32_t>(burn_in.ladder.size() - 1)),
      lineage_(burn_in.lineage),
      visits_(burn_in.ladder.size(), 0),
      proposed_(burn_in.ladder.size() - 1, 0),
      accepted_(burn_in.ladder.size() - 1, 0) {
  CHECK_EQ(burn_in.log_z_steps.size() + 1, burn_in.ladder.size());
  // Sum the steps of log Z from the coolest level to the hottest. If a level has zero density, that
  // level and all hotter levels get no weight.
  for (std::size_t level = burn_in.log_z_steps.size(); level-- > 0;)
    log_weights_[level] = log_weights_[level + 1] + burn_in.log_z_steps[level];
}

std::optional<plan::Unit> SimulatedTempering::next_unit(std::uint64_t horizon,
                                                        std::uint32_t /*scans_max*/) {
  // The next level depends on the previous scan.
  if (handed_out_ || scan_ >= horizon) return std::nullopt;
  handed_out_ = true;
  return plan::Unit{.replica = {burn_in_.chain, burn_in_.coolest},
                    .seed = burn_in_.seed,
                    .first_scan = base::ScanIndex{scan_},
                    .scans = 1,
                    .starts = false,
                    .lineage = lineage_,
                    .inverse_temperatures = {burn_in_.ladder[level_]},
                    .proposal_scales = burn_in_.scales[level_]};
}

void SimulatedTempering::consume(base::ReplicaId replica, std::uint64_t first_scan,
                                 std::span<const plan::ScanRecord> records) {
  CHECK_EQ(replica.value, burn_in_.coolest.value);
  CHECK_EQ(first_scan, scan_);
  handed_out_ = false;
  for (const plan::ScanRecord& record : records) {
    CHECK_EQ(record.inverse_temperature, burn_in_.ladder[level_]);
    lineage_ = record.lineage;
    ++visits_[level_];
    if (level_ == 0) was_hot_ = true;
    if (level_ + 1 == visits_.size()) {
      draw_scans_.push_back(static_cast<double>(scan_));
      if (was_hot_) ++round_trips_;
      was_hot_ = false;
    }
    solutions_.add(scan_, record);
    move(record.log_constraint);
    ++scan_;
  }
}

/// Moves to the next scan's level.
void SimulatedTempering::move(double log_constraint) {
  random::Stream stream(
      {.seed = burn_in_.seed, .chain = burn_in_.chain, .purpose = random::Purpose::level}, scan_);
  const bool up = stream.uniform() < 0.5;
  const double log_u = math::log(stream.uniform());
  const std::uint32_t to = proposed_level(level_, up, static_cast<std::uint32_t>(visits_.size()));
  if (to == level_) return;
  const std::uint32_t pair = std::min(level_, to);
  ++proposed_[pair];
  if (log_u < log_level_ratio({.ladder = burn_in_.ladder,
                               .log_weights = log_weights_,
                               .from = level_,
                               .to = to,
                               .l = log_constraint})) {
    ++accepted_[pair];
    level_ = to;
  }
}

std::vector<ChainPart::Row> SimulatedTempering::rows() const {
  std::vector<double> visits;
  std::vector<double> acceptance;
  for (std::size_t level = 0; level < visits_.size(); ++level) {
    visits.push_back(static_cast<double>(visits_[level]));
    acceptance.push_back(level < proposed_.size() ? static_cast<double>(accepted_[level]) /
                                                        static_cast<double>(proposed_[level])
                                                  : std::numeric_limits<double>::quiet_NaN());
  }
  return {
      {"walk_inverse_temperature", "exponent of the constraint's density at the level",
       "walk_level", burn_in_.ladder},
      {"walk_log_weight", "log weight of the level", "walk_level", log_weights_},
      {"walk_visits", "number of scans at the level", "walk_level", visits},
      {"walk_acceptance", "acceptance rate of moves between the level and the next cooler level",
       "walk_level", acceptance},
      {"walk_round_trips",
       "number of round trips from inverse temperature 1 to the prior and back",
       "",
       {static_cast<double>(round_trips_)}},
      {"draw_scan", "scan of the draw", "draw", draw_scans_}};
}

}  // namespace sleight::sampling
