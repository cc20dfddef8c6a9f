#include "worker/sampling/stop_rule.h"

#include <algorithm>

#include "common/base/check.h"

namespace sleight::sampling {

std::uint64_t scans_through_round(std::uint64_t round_scans, std::uint32_t rounds) {
  if (rounds >= 64) return StopJudge::k_no_end;
  const std::uint64_t lengths = (std::uint64_t{1} << rounds) - 1;
  if (round_scans > StopJudge::k_no_end / std::max<std::uint64_t>(lengths, 1))
    return StopJudge::k_no_end;
  return round_scans * lengths;
}

namespace {

std::uint64_t sum_of(std::uint64_t a, std::uint64_t b) {
  return a > StopJudge::k_no_end - b ? StopJudge::k_no_end : a + b;
}

}  // namespace

StopJudge::StopJudge(const StopRule& rule, std::uint64_t round_scans, std::uint64_t before)
    : rule_(rule), round_scans_(round_scans), before_(before) {
  CHECK_GE(round_scans, 1U);
  CHECK(rule.scans || rule.rounds || rule.independent_solutions);
  if (rule.scans) end_ = *rule.scans;
  if (rule.rounds)
    end_ = std::min(end_, sum_of(before, scans_through_round(round_scans, *rule.rounds)));
  judge(0, [](std::uint64_t) { return std::uint64_t{0}; });
}

std::uint64_t StopJudge::end_of_round(std::uint32_t round) const {
  return sum_of(before_, scans_through_round(round_scans_, round));
}

std::vector<plan::EndedRound> StopJudge::rounds_between(std::uint64_t after,
                                                        std::uint64_t until) const {
  std::vector<plan::EndedRound> ended;
  for (std::uint32_t round = 1; end_of_round(round) <= until && end_of_round(round) != k_no_end;
       ++round) {
    if (end_of_round(round) > after)
      ended.push_back({.round = round, .scans = end_of_round(round)});
  }
  return ended;
}

std::optional<std::uint64_t> StopJudge::scans_in_any_case() const {
  if (!rule_.independent_solutions) return std::nullopt;
  return std::min(end_of_round(1), rule_.scans.value_or(k_no_end));
}

void StopJudge::judge(std::uint64_t reached_by_all, const SolutionsBefore& solutions_before) {
  horizon_ = end_;
  if (!rule_.independent_solutions) return;
  while (reached_by_all >= round_end() && round_end() < end_) {
    if (solutions_before(round_end()) >= *rule_.independent_solutions) {
      end_ = round_end();
      break;
    }
    ++round_;
  }
  horizon_ = std::min(end_, round_end());
}

}  // namespace sleight::sampling
