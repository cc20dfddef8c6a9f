#include "worker/worlds/spelling/proposals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "common/base/check.h"
#include "common/math/elementary.h"
#include "common/random/distributions.h"

namespace sleight::worlds::spelling {
namespace {

Vec3 gaussian(random::Stream& stream, double sd) {
  const random::Normal normal{.mean = 0, .sd = sd};
  const double x = normal.draw(stream);
  const double y = normal.draw(stream);
  const double z = normal.draw(stream);
  return {x, y, z};
}

/// Draws a signed length N(0, sd) in a uniform direction. This distribution is denser near 0 than a
/// Gaussian.
Vec3 length_and_direction(random::Stream& stream, double sd) {
  const Vec3 direction = random::UniformDirection3{}.draw(stream);
  return random::Normal{.mean = 0, .sd = sd}.draw(stream) * direction;
}

Vec3 draw_offset(Kernel kernel, double sd, random::Stream& stream) {
  return kernel == Kernel::thesis ? length_and_direction(stream, sd) : gaussian(stream, sd);
}

/// Wraps x onto [-half, half).
double wrapped(double x, double half) {
  const double turns = std::floor((x + half) / (2 * half));
  return std::clamp(x - turns * (2 * half), -half, half);
}

/// Maximum flip probability. The maximum is below 1, because reverse proposals must be possible.
constexpr double k_flip_probability_max = 0.9;

/// Disables each active ball, or enables each inactive ball, with a probability. Returns log q
/// ratio.
double flip_balls(const Prior& prior, const ProposalParameters& p, double scale, bool enable,
                  State& state, random::Stream& stream) {
  const double flip_probability =
      scale == 1 ? p.flip_probability
                 : std::min(p.flip_probability * scale, k_flip_probability_max);
  const auto present = static_cast<double>(state.active_count());
  double flipped = 0;
  for (std::size_t ball = 0; ball < state.active.size(); ++ball) {
    if ((state.active[ball] != 0) == enable || stream.uniform() >= flip_probability) continue;
    ++flipped;
    state.active[ball] = enable ? 1 : 0;
    state.drops_m[ball] = enable ? prior.draw_drop(stream) : Vec2(0, 0);
  }
  const double sign = enable ? -1 : 1;
  if (p.kernel == Kernel::thesis) return sign * flipped * prior.log_area();
  const double stays = sign * (static_cast<double>(prior.balls) - 2 * present) + flipped;
  return stays * math::log(1 - flip_probability) - sign * flipped * prior.log_area();
}

}  // namespace

std::uint32_t State::active_before(std::size_t ball) const {
  return std::accumulate(active.begin(), active.begin() + static_cast<std::ptrdiff_t>(ball), 0U);
}

double Prior::log_area() const {
  return math::log(4 * drop_half_m.x() * drop_half_m.y());
}

Vec2 Prior::draw_drop(random::Stream& stream) const {
  const double x = random::Uniform{.low = -drop_half_m.x(), .high = drop_half_m.x()}.draw(stream);
  const double y = random::Uniform{.low = -drop_half_m.y(), .high = drop_half_m.y()}.draw(stream);
  return {x, y};
}

bool Prior::may_drop_at(const Vec2& drop_m) const {
  return !(std::fabs(drop_m.x()) > drop_half_m.x() || std::fabs(drop_m.y()) > drop_half_m.y());
}

double Prior::log_density(const State& state) const {
  CHECK_EQ(state.offsets_m.size(), std::size_t{vertices});
  CHECK_EQ(state.active.size(), std::size_t{balls});
  const random::NormalLogDensity log_density({.mean = 0, .sd = vertex_sd_m});
  double sum = 0;
  for (const Vec3& offset_m : state.offsets_m) {
    for (int axis = 0; axis < 3; ++axis)
      sum += log_density(offset_m[axis]);
  }
  sum += static_cast<double>(balls) * math::log(0.5);
  for (std::size_t ball = 0; ball < balls; ++ball) {
    if (state.active[ball] == 0) continue;
    const Vec2& drop_m = state.drops_m[ball];
    if (!may_drop_at(drop_m)) return -std::numeric_limits<double>::infinity();
    sum -= log_area();
  }
  return sum;
}

State draw_state(const Prior& prior, Kernel kernel, random::Stream& stream) {
  State state;
  for (std::uint32_t v = 0; v < prior.vertices; ++v)
    state.offsets_m.push_back(draw_offset(kernel, prior.vertex_sd_m, stream));
  for (std::uint32_t ball = 0; ball < prior.balls; ++ball) {
    const bool active = random::Bernoulli{.p = 0.5}.draw(stream);
    state.active.push_back(active ? 1 : 0);
    state.drops_m.push_back(active ? prior.draw_drop(stream) : Vec2(0, 0));
  }
  return state;
}

Kind drawn_kind(const ProposalParameters& p, random::Stream& stream) {
  const std::array shares{p.change_all,   p.change_vertices, p.change_ball, p.disable_balls,
                          p.enable_balls, p.aim_ball,        p.scatter_ball};
  return static_cast<Kind>(random::draw_by_share(shares, stream));
}

sampling::Proposal<State> propose_of(Kind kind, const Prior& prior, const ProposalParameters& p,
                                     const State& state, std::span<const double> scales,
                                     random::Stream& stream) {
  const auto scale_of = [&](Kind of) {
    return scales.empty() ? 1 : scales[static_cast<std::size_t>(of)];
  };
  const double scale = scale_of(kind);
  // Both kinds share a scale, because they are each other's reverse.
  const double flip_scale = scale_of(Kind::disable_balls);
  sampling::Proposal<State> proposal{.candidate = state, .kind = static_cast<std::uint32_t>(kind)};
  State& candidate = proposal.candidate;
  switch (kind) {
    case Kind::change_all:
      candidate = draw_state(prior, p.kernel, stream);
      if (p.kernel == Kernel::correct)
        proposal.log_q_ratio = prior.log_density(state) - prior.log_density(candidate);
      break;
    case Kind::change_vertices:
      if (p.vertex_redraw > 0 && stream.uniform() < p.vertex_redraw) {
        const auto which = random::UniformInteger{.count = candidate.offsets_m.size()}.draw(stream);
        candidate.offsets_m[which] = draw_offset(p.kernel, prior.vertex_sd_m, stream);
        proposal.log_q_ratio = prior.log_density(state) - prior.log_density(candidate);
        break;
      }
      for (Vec3& offset_m : candidate.offsets_m) {
        if (stream.uniform() < p.vertex_probability)
          offset_m += draw_offset(p.kernel, p.vertex_sd_m * scale, stream);
      }
      break;
    case Kind::change_ball: {
      const std::uint32_t active = state.active_count();
      if (active == 0) break;
      std::uint64_t wanted = random::UniformInteger{.count = active}.draw(stream);
      std::size_t ball = 0;
      while (state.active[ball] == 0 || wanted-- > 0)
        ++ball;
      const Vec2 direction = random::UniformDirection2{}.draw(stream);
      const double length_m = random::Normal{.mean = 0, .sd = p.ball_sd_m * scale}.draw(stream);
      Vec2& drop_m = candidate.drops_m[ball];
      for (int axis = 0; axis < 2; ++axis) {
        drop_m[axis] = wrapped(drop_m[axis] + length_m * direction[axis], prior.drop_half_m[axis]);
      }
      break;
    }
    case Kind::disable_balls:
    case Kind::enable_balls:
      proposal.log_q_ratio =
          flip_balls(prior, p, flip_scale, kind == Kind::enable_balls, candidate, stream);
      break;
    case Kind::aim_ball:
    case Kind::scatter_ball:
    case Kind::solo_walk:
    case Kind::solo_step:
      CHECK(false);
  }
  return proposal;
}

}  // namespace sleight::worlds::spelling
