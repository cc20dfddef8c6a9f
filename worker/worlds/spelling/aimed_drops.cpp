#include "worker/worlds/spelling/aimed_drops.h"

#include <algorithm>
#include <limits>

#include "common/base/check.h"
#include "common/math/elementary.h"
#include "common/random/distributions.h"

namespace sleight::worlds::spelling {
namespace {

constexpr double k_impossible = -std::numeric_limits<double>::infinity();

/// Of one ball: p_w of how it is.
double log_prior_of_ball(const Prior& prior, const State& state, std::size_t ball) {
  return math::log(0.5) - (state.active[ball] != 0 ? prior.log_area() : 0);
}

std::vector<std::size_t> loose_balls(const Filling& filling) {
  std::vector<std::size_t> loose;
  for (std::size_t ball = 0; ball < filling.size(); ++ball) {
    if (filling[ball] == k_fills_none) loose.push_back(ball);
  }
  return loose;
}

std::vector<std::size_t> empty_bins(std::size_t bins, const Filling& filling) {
  std::vector<std::uint8_t> full(bins, 0);
  for (const std::int16_t bin : filling) {
    if (bin != k_fills_none) full[static_cast<std::size_t>(bin)] = 1;
  }
  std::vector<std::size_t> empty;
  for (std::size_t bin = 0; bin < bins; ++bin) {
    if (full[bin] == 0) empty.push_back(bin);
  }
  return empty;
}

std::size_t one_of(const std::vector<std::size_t>& choices, random::Stream& stream) {
  return choices[random::UniformInteger{.count = choices.size()}.draw(stream)];
}

double log_of(std::size_t count) {
  return math::log(static_cast<double>(count));
}

/// The ball in which two states differ; nothing if they don't.
std::optional<std::size_t> changed_ball(const State& a, const State& b) {
  for (std::size_t ball = 0; ball < a.active.size(); ++ball) {
    if (a.active[ball] != b.active[ball] || a.drops_m[ball] != b.drops_m[ball]) return ball;
  }
  return std::nullopt;
}

double log_scatter_q(const Prior& prior, const AimParameters& p, const State& to,
                     std::size_t ball) {
  return math::log(p.scatter) - log_of(prior.balls) + log_prior_of_ball(prior, to, ball);
}

}  // namespace

double Windows::log_area(std::size_t bin) const {
  const Vec2 size_m = high_m[bin] - low_m[bin];
  return math::log(size_m.x() * size_m.y());
}

std::optional<std::size_t> Windows::above(const Vec2& drop_m) const {
  for (std::size_t bin = 0; bin < count(); ++bin) {
    if (drop_m.x() >= low_m[bin].x() && drop_m.x() <= high_m[bin].x() &&
        drop_m.y() >= low_m[bin].y() && drop_m.y() <= high_m[bin].y())
      return bin;
  }
  return std::nullopt;
}

std::optional<sampling::Proposal<State>> aim_ball(const Prior& prior, const Windows& windows,
                                                  const AimParameters& p, const State& state,
                                                  const Filling& filling, random::Stream& stream) {
  const std::vector<std::size_t> loose = loose_balls(filling);
  const std::vector<std::size_t> empty = empty_bins(windows.count(), filling);
  if (loose.empty() || empty.empty()) return std::nullopt;
  const std::size_t ball = one_of(loose, stream);
  const std::size_t bin = one_of(empty, stream);
  const double x =
      random::Uniform{.low = windows.low_m[bin].x(), .high = windows.high_m[bin].x()}.draw(stream);
  const double y =
      random::Uniform{.low = windows.low_m[bin].y(), .high = windows.high_m[bin].y()}.draw(stream);
  sampling::Proposal<State> proposal{.candidate = state};
  proposal.candidate.active[ball] = 1;
  proposal.candidate.drops_m[ball] = {x, y};
  const double log_there =
      math::log(p.aim) - log_of(loose.size()) - log_of(empty.size()) - windows.log_area(bin);
  proposal.log_q_ratio = log_scatter_q(prior, p, state, ball) - log_there;
  return proposal;
}

sampling::Proposal<State> scatter_ball(const Prior& prior, const Windows& windows,
                                       const AimParameters& p, const State& state,
                                       random::Stream& stream) {
  const std::size_t ball = random::UniformInteger{.count = prior.balls}.draw(stream);
  sampling::Proposal<State> proposal{.candidate = state, .ratio_waits = true};
  State& candidate = proposal.candidate;
  candidate.active[ball] = random::Bernoulli{.p = 0.5}.draw(stream) ? 1 : 0;
  candidate.drops_m[ball] = {0, 0};
  if (candidate.active[ball] != 0) {
    const Vec2& half_m = prior.drop_half_m;
    const double x = random::Uniform{.low = -half_m.x(), .high = half_m.x()}.draw(stream);
    const double y = random::Uniform{.low = -half_m.y(), .high = half_m.y()}.draw(stream);
    candidate.drops_m[ball] = {x, y};
  }
  // Back it is a ball of one at least, into a bin of one at least.
  const auto bin = state.active[ball] != 0 ? windows.above(state.drops_m[ball]) : std::nullopt;
  proposal.log_q_ratio =
      bin ? math::log(p.aim) - windows.log_area(*bin) - log_scatter_q(prior, p, candidate, ball)
          : k_impossible;
  return proposal;
}

double scatter_log_q_ratio(const Prior& prior, const Windows& windows, const AimParameters& p,
                           const State& state, const State& candidate,
                           const Filling& candidate_filling) {
  const auto ball = changed_ball(state, candidate);
  // Out and out again: the state is the candidate.
  if (!ball) return 0;
  if (state.active[*ball] == 0 || candidate_filling[*ball] != k_fills_none) return k_impossible;
  const auto bin = windows.above(state.drops_m[*ball]);
  if (!bin) return k_impossible;
  const std::vector<std::size_t> empty = empty_bins(windows.count(), candidate_filling);
  if (!std::ranges::binary_search(empty, *bin)) return k_impossible;
  const double log_back = math::log(p.aim) - log_of(loose_balls(candidate_filling).size()) -
                          log_of(empty.size()) - windows.log_area(*bin);
  return log_back - log_scatter_q(prior, p, candidate, *ball);
}

}  // namespace sleight::worlds::spelling
