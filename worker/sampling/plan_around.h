// A plan that changes some functions of another plan. All other functions are the other plan's. Not
// thread-safe.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "common/plan/plan.h"

namespace sleight::sampling {

class PlanAround : public plan::Plan {
 public:
  bool finished() const override { return plan().finished(); }
  base::BytesView start_state(plan::ReplicaKey replica) const override {
    return plan().start_state(replica);
  }
  std::uint64_t scans_common() const override { return plan().scans_common(); }
  plan::Draws draws() const override { return plan().draws(); }
  std::uint64_t solutions_found() const override { return plan().solutions_found(); }
  std::optional<std::uint64_t> solutions_wanted() const override {
    return plan().solutions_wanted();
  }
  std::vector<plan::Solution> solutions_between(std::uint64_t after,
                                                std::uint64_t until) const override {
    return plan().solutions_between(after, until);
  }
  std::vector<plan::EndedRound> rounds_between(std::uint64_t after,
                                               std::uint64_t until) const override {
    return plan().rounds_between(after, until);
  }
  plan::Finds finds() const override { return plan().finds(); }
  std::uint64_t starts_done() const override { return plan().starts_done(); }
  std::vector<plan::Find> finds_between(std::uint64_t first, std::uint64_t end) const override {
    return plan().finds_between(first, end);
  }
  plan::Odds odds() const override { return plan().odds(); }
  std::optional<std::uint64_t> round_trips() const override { return plan().round_trips(); }
  std::uint64_t scans_consumed() const override { return plan().scans_consumed(); }
  std::optional<std::uint64_t> scans_total() const override { return plan().scans_total(); }
  plan::Report report() const override { return plan().report(); }
  bool learns() const override { return plan().learns(); }

 protected:
  explicit PlanAround(std::unique_ptr<plan::Plan> plan) : plan_(std::move(plan)) {}
  plan::Plan& plan() const { return *plan_; }

 private:
  std::unique_ptr<plan::Plan> plan_;
};

}  // namespace sleight::sampling
