#include "worker/worlds/spelling/aimed_drops.h"

#include <algorithm>
#include <limits>

#include "common/base/check.h"
#include "common/math/elementary.h"
#include "common/random/distributions.h"

namespace sleight::worlds::spelling {
namespace {

constexpr double k_impossible = -std::numeric_limits<double>::infinity();

double log_prior_of_ball(const Prior& prior, const State& state, std::size_t ball) {
  return math::log(0.5) - (state.active[ball] != 0 ? prior.log_area() : 0);
}

std::vector<std::size_t> balls_that(bool fill, const Filling& filling) {
  std::vector<std::size_t> balls;
  for (std::size_t ball = 0; ball < filling.size(); ++ball) {
    if ((filling[ball] != k_fills_none) == fill) balls.push_back(ball);
  }
  return balls;
}

std::size_t one_of(const std::vector<std::size_t>& choices, random::Stream& stream) {
  return choices[random::UniformInteger{.count = choices.size()}.draw(stream)];
}

Vec2 draw_in(const Vec2& low_m, const Vec2& high_m, random::Stream& stream) {
  const double x = random::Uniform{.low = low_m.x(), .high = high_m.x()}.draw(stream);
  const double y = random::Uniform{.low = low_m.y(), .high = high_m.y()}.draw(stream);
  return {x, y};
}

double log_of(std::size_t count) {
  return math::log(static_cast<double>(count));
}

/// Returns the ball in which two states differ. If they don't differ, returns nothing.
std::optional<std::size_t> changed_ball(const State& a, const State& b) {
  for (std::size_t ball = 0; ball < a.active.size(); ++ball) {
    if (a.active[ball] != b.active[ball] || a.drops_m[ball] != b.drops_m[ball]) return ball;
  }
  return std::nullopt;
}

double log_aim_q(const ProposalParameters& p, std::size_t loose, double density_pm2) {
  return math::log(p.aim_ball) - log_of(loose) + math::log(density_pm2);
}

double log_scatter_q(const Prior& prior, const ProposalParameters& p, std::size_t right,
                     const State& to, std::size_t ball) {
  return math::log(p.scatter_ball) - log_of(right) + log_prior_of_ball(prior, to, ball);
}

}  // namespace

std::vector<std::uint8_t> full_bins(std::size_t bins, const Filling& filling) {
  std::vector<std::uint8_t> full(bins, 0);
  for (const std::int16_t bin : filling) {
    if (bin != k_fills_none) full[static_cast<std::size_t>(bin)] = 1;
  }
  return full;
}

std::vector<std::size_t> empty_bins(std::size_t bins, const Filling& filling) {
  const std::vector<std::uint8_t> full = full_bins(bins, filling);
  std::vector<std::size_t> empty;
  for (std::size_t bin = 0; bin < bins; ++bin) {
    if (full[bin] == 0) empty.push_back(bin);
  }
  return empty;
}

void Windows::add(const Vec2& middle_m, double bin_m, const Vec2& half_m) {
  auto& windows = of_bin_.emplace_back();
  for (std::size_t i = 0; i < windows.size(); ++i) {
    Window& window = windows[i];
    window = {.low_m = -half_m, .high_m = half_m};
    const bool anywhere = i + 1 == windows.size();
    if (!anywhere) {
      const double reach_m = (static_cast<double>(i) + 0.5) * bin_m;
      const Vec2 reach(reach_m, reach_m);
      window.low_m = (middle_m - reach).cwiseMax(-half_m).cwiseMin(half_m);
      window.high_m = (middle_m + reach).cwiseMax(-half_m).cwiseMin(half_m);
    }
    const Vec2 size_m = window.high_m - window.low_m;
    window.density_pm2 = k_window_shares[i] / (size_m.x() * size_m.y());
  }
}

Vec2 Windows::draw(std::size_t bin, random::Stream& stream) const {
  double u = stream.uniform();
  std::size_t i = 0;
  while (i + 1 < k_window_shares.size() && u >= k_window_shares[i])
    u -= k_window_shares[i++];
  const Window& window = of_bin_[bin][i];
  return draw_in(window.low_m, window.high_m, stream);
}

double Windows::density(std::size_t bin, const Vec2& drop_m) const {
  double sum = 0;
  for (const Window& window : of_bin_[bin]) {
    const bool inside = (drop_m.array() >= window.low_m.array()).all() &&
                        (drop_m.array() <= window.high_m.array()).all();
    if (inside) sum += window.density_pm2;
  }
  return sum;
}

double Windows::density(std::span<const std::size_t> bins, const Vec2& drop_m) const {
  double sum = 0;
  for (const std::size_t bin : bins)
    sum += density(bin, drop_m);
  return sum / static_cast<double>(bins.size());
}

double Windows::greatest_density(const Vec2& drop_m) const {
  double greatest = 0;
  for (std::size_t bin = 0; bin < bins(); ++bin)
    greatest = std::max(greatest, density(bin, drop_m));
  return greatest;
}

std::optional<sampling::Proposal<State>> aim_ball(const Prior& prior, const Windows& windows,
                                                  const ProposalParameters& p, const State& state,
                                                  const Filling& filling, random::Stream& stream) {
  const std::vector<std::size_t> loose = balls_that(false, filling);
  const std::vector<std::size_t> empty = empty_bins(windows.bins(), filling);
  if (loose.empty() || empty.empty()) return std::nullopt;
  const std::size_t ball = one_of(loose, stream);
  sampling::Proposal<State> proposal{.candidate = state, .ratio_waits = true};
  proposal.candidate.active[ball] = 1;
  proposal.candidate.drops_m[ball] = windows.draw(one_of(empty, stream), stream);
  const double density_pm2 = windows.density(empty, proposal.candidate.drops_m[ball]);
  // In the candidate, the aimed ball fills a bin, so R has at least one ball.
  proposal.log_q_ratio =
      log_scatter_q(prior, p, 1, state, ball) - log_aim_q(p, loose.size(), density_pm2);
  return proposal;
}

std::optional<sampling::Proposal<State>> scatter_ball(const Prior& prior, const Windows& windows,
                                                      const ProposalParameters& p,
                                                      const State& state, const Filling& filling,
                                                      random::Stream& stream) {
  const std::vector<std::size_t> right = balls_that(true, filling);
  if (right.empty()) return std::nullopt;
  const std::size_t ball = one_of(right, stream);
  sampling::Proposal<State> proposal{.candidate = state, .ratio_waits = true};
  State& candidate = proposal.candidate;
  candidate.active[ball] = random::Bernoulli{.p = 0.5}.draw(stream) ? 1 : 0;
  candidate.drops_m[ball] = candidate.active[ball] != 0 ? prior.draw_drop(stream) : Vec2(0, 0);
  // In the candidate, the scattered ball fills no bin, so L has at least one ball.
  proposal.log_q_ratio = log_aim_q(p, 1, windows.greatest_density(state.drops_m[ball])) -
                         log_scatter_q(prior, p, right.size(), candidate, ball);
  return proposal;
}

double aim_log_q_ratio(const Prior& prior, const Windows& windows, const ProposalParameters& p,
                       const State& state, const Filling& filling, const State& candidate,
                       const Filling& candidate_filling) {
  const auto ball = changed_ball(state, candidate);
  if (!ball || filling[*ball] != k_fills_none || candidate_filling[*ball] == k_fills_none)
    return k_impossible;
  const std::size_t loose = balls_that(false, filling).size();
  const std::size_t right = balls_that(true, candidate_filling).size();
  const double density_pm2 =
      windows.density(empty_bins(windows.bins(), filling), candidate.drops_m[*ball]);
  return log_scatter_q(prior, p, right, state, *ball) - log_aim_q(p, loose, density_pm2);
}

double scatter_log_q_ratio(const Prior& prior, const Windows& windows, const ProposalParameters& p,
                           const State& state, const Filling& filling, const State& candidate,
                           const Filling& candidate_filling) {
  const double back =
      aim_log_q_ratio(prior, windows, p, candidate, candidate_filling, state, filling);
  return back == k_impossible ? k_impossible : -back;
}

}  // namespace sleight::worlds::spelling
