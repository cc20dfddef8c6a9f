#include "tests/thesis/figures_2/chain.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "common/base/check.h"
#include "worker/sampling/metropolis_hastings.h"
#include "worker/worlds/spelling/spelling.h"

namespace sleight::thesis {
namespace {

using worlds::spelling::Kind;
using worlds::spelling::Prior;
using worlds::spelling::Spelling;
using worlds::spelling::State;
using Sample = sampling::Sample<Spelling>;

Iteration iteration_of(const Prior& prior, const Sample& sample) {
  Iteration iteration{.filled = sample.outcome.filled};
  for (const math::Vec3& offset_m : sample.state.offsets_m)
    iteration.log_p_offsets -=
        math::dot(offset_m, offset_m) / (2 * prior.vertex_sd_m * prior.vertex_sd_m);
  iteration.log_p = sample.log_constraint + iteration.log_p_offsets -
                    sample.state.active_count() * prior.log_area();
  return iteration;
}

class BestStates {
 public:
  void offer(const Sample& sample) {
    const std::uint32_t k = sample.outcome.filled;
    if (!sample.outcome.is_animation()) return;
    if (k > most_) {
      most_ = k;
      firsts_.clear();
      away_ = true;
    }
    if (k == most_) {
      if (away_ && firsts_.size() < k_states_max) firsts_.push_back(sample.state);
      away_ = false;
      last_ = sample.state;
    }
    away_ = away_ || k < most_;
  }

  std::vector<State> take() {
    if (last_) firsts_.push_back(*std::move(last_));
    return std::move(firsts_);
  }

 private:
  std::uint32_t most_ = 0;
  bool away_ = true;
  std::vector<State> firsts_;
  std::optional<State> last_;
};

}  // namespace

Chain run_chain(const worlds::spelling::Parameters& parameters, const ChainOptions& options,
                std::atomic<std::uint64_t>& done) {
  const Spelling world(parameters);
  Chain chain{.balls = world.balls(), .vertices = world.prior().vertices};
  chain.iterations.reserve(options.iterations + 1);
  BestStates best;
  const sampling::ChainStreams streams{.seed = options.seed, .chain = {}, .replica = {}};
  Sample current = sampling::draw_afresh(world, streams, 0);
  chain.iterations.push_back(iteration_of(world.prior(), current));
  best.offer(current);
  for (std::uint64_t i = 1; i <= options.iterations; ++i) {
    const sampling::StepReport step =
        sampling::metropolis_hastings_step(world, 1, streams, i, current);
    Iteration iteration = iteration_of(world.prior(), current);
    iteration.kind = static_cast<Kind>(step.kind);
    iteration.accepted = step.accepted;
    chain.iterations.push_back(iteration);
    if (step.accepted) best.offer(current);
    ++done;
  }
  chain.best = best.take();
  return chain;
}

std::vector<Order> orders_of(const worlds::spelling::Parameters& parameters,
                             const std::vector<State>& states) {
  const Spelling world(parameters);
  std::vector<Order> orders;
  for (const State& state : states)
    orders.push_back(world.balls_of_bins(state));
  return orders;
}

std::uint32_t different_bins(const Order& a, const Order& b) {
  CHECK_EQ(a.size(), b.size());
  std::uint32_t different = 0;
  for (std::size_t bin = 0; bin < a.size(); ++bin)
    different += a[bin] != b[bin] ? 1 : 0;
  return different;
}

std::uint32_t distinct_count(const std::vector<Order>& orders, std::uint32_t balls) {
  std::vector<const Order*> counted;
  for (const Order& order : orders) {
    const bool new_one = std::ranges::all_of(
        counted, [&](const Order* other) { return 2 * different_bins(order, *other) >= balls; });
    if (new_one) counted.push_back(&order);
  }
  return static_cast<std::uint32_t>(counted.size());
}

std::pair<Order, Order> most_different(const std::vector<Order>& orders) {
  CHECK(!orders.empty());
  std::pair most{orders.front(), orders.front()};
  for (std::size_t a = 0; a < orders.size(); ++a) {
    for (std::size_t b = a + 1; b < orders.size(); ++b) {
      if (different_bins(orders[a], orders[b]) > different_bins(most.first, most.second))
        most = {orders[a], orders[b]};
    }
  }
  return most;
}

}  // namespace sleight::thesis
