#include "worker/worlds/dice/proposals.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/check.h"
#include "common/math/elementary.h"
#include "common/random/distributions.h"

namespace sleight::worlds::dice {
namespace {

double normal(double sd, random::Stream& stream) {
  return random::Normal{.mean = 0, .sd = sd}.draw(stream);
}

Kind drawn_kind(const ProposalParameters& p, random::Stream& stream) {
  const std::array shares{p.change_all, p.change_die, p.change_start, p.change_control,
                          p.change_contact};
  return static_cast<Kind>(random::draw_by_share(shares, stream));
}

/// Returns a step's factor, scale * 2^-n. n is uniform from 0 to `halvings`.
double drawn_factor(const ProposalParameters& p, double scale, random::Stream& stream) {
  const std::uint64_t halvings =
      random::UniformInteger{.count = std::uint64_t{p.halvings} + 1}.draw(stream);
  return std::ldexp(scale, -static_cast<int>(halvings));
}

std::size_t drawn_die(const State& state, random::Stream& stream) {
  return static_cast<std::size_t>(random::UniformInteger{.count = state.dice.size()}.draw(stream));
}

/// A random component of a die's throw.
struct Component {
  Vec3 DieThrow::*vector = nullptr;  ///< null: the orientation
  int axis = 0;
  double step = 0;
};

std::vector<Component> components_of(const ProposalParameters& p, const DieStart& start) {
  std::vector<Component> components;
  const auto add = [&](const Vec3& sd, Vec3 DieThrow::*vector, double step) {
    for (int axis = 0; axis < 3; ++axis) {
      if (sd[axis] > 0) components.push_back({.vector = vector, .axis = axis, .step = step});
    }
  };
  add(start.position_sd_m, &DieThrow::position_m, p.position_m);
  add(start.velocity_sd_mps, &DieThrow::velocity_mps, p.velocity_mps);
  add(start.spin_sd_radps, &DieThrow::spin_radps, p.spin_radps);
  if (start.orientation == StartOrientation::uniform) components.push_back({.step = p.turn_rad});
  return components;
}

void change_start(const Parameters& parameters, double scale, State& state,
                  random::Stream& stream) {
  const ProposalParameters& p = parameters.proposal;
  const std::size_t die = drawn_die(state, stream);
  const std::vector<Component> components = components_of(p, parameters.world.dice[die]);
  if (components.empty()) return;
  const Component& component = components[static_cast<std::size_t>(
      random::UniformInteger{.count = components.size()}.draw(stream))];
  const double sd = component.step * drawn_factor(p, scale, stream);
  DieThrow& one = state.dice[die];
  if (component.vector != nullptr) {
    (one.*component.vector)[component.axis] += normal(sd, stream);
  } else {
    const Vec3 axis = random::UniformDirection3{}.draw(stream);
    const Quat turn = math::quaternion_of_rotation_vector(normal(sd, stream) * axis);
    one.orientation = math::normalized(math::composed(turn, one.orientation));
  }
}

/// Changes one random field of a control point.
void change_field(const Parameters& parameters, GridIndex index, double scale, State& state,
                  random::Stream& stream) {
  const ProposalParameters& p = parameters.proposal;
  const TableParameters& table = parameters.world.table;
  enum class Field : std::uint8_t { height, restitution, friction };
  std::vector<Field> fields;
  if (table.height_sd_m > 0) fields.push_back(Field::height);
  if (!table.restitution.is_constant()) fields.push_back(Field::restitution);
  if (!table.friction.is_constant()) fields.push_back(Field::friction);
  if (fields.empty()) return;
  const Field field =
      fields[static_cast<std::size_t>(random::UniformInteger{.count = fields.size()}.draw(stream))];
  const double factor = drawn_factor(p, scale, stream);
  SurfaceControl control = control_at(parameters.world, state, index);
  switch (field) {
    case Field::height:
      control.height_m += normal(p.height_m * factor, stream);
      break;
    case Field::restitution:
      control.restitution = reflected(control.restitution + normal(p.restitution * factor, stream),
                                      table.restitution);
      break;
    case Field::friction:
      control.friction =
          reflected(control.friction + normal(p.friction * factor, stream), table.friction);
      break;
  }
  set_override(state.overrides, {.index = index, .control = control});
}

GridIndex drawn_control(const TableParameters& table, random::Stream& stream) {
  const std::uint64_t place =
      random::UniformInteger{.count = std::uint64_t{table.columns} * table.rows}.draw(stream);
  const GridIndex first = first_of(table);
  return {first.i + static_cast<std::int32_t>(place / table.rows),
          first.j + static_cast<std::int32_t>(place % table.rows)};
}

/// Draws a contact. Null if the apron was drawn.
const ContactShare* drawn_contact(const ContactShares& contacts, random::Stream& stream) {
  double u = stream.uniform();
  for (const ContactShare& contact : contacts) {
    if (u < contact.share) return &contact;
    u -= contact.share;
  }
  return nullptr;
}

}  // namespace

double share_of(const ContactShares& contacts, GridIndex index) {
  const auto found = std::ranges::lower_bound(contacts, index, {}, &ContactShare::index);
  return found == contacts.end() || found->index != index ? 0 : found->share;
}

double reflected(double x, const Range& range) {
  const double width = range.high - range.low;
  CHECK_GT(width, 0);
  // Map x to a ring of twice the width. The ring's second half runs backwards.
  double along = x - range.low;
  along -= 2 * width * std::floor(along / (2 * width));
  if (along > width) along = 2 * width - along;
  return std::clamp(range.low + along, range.low, range.high);
}

sampling::Proposal<State> propose(const Parameters& parameters, const State& state,
                                  const ContactShares& contacts, std::span<const double> scales,
                                  random::Stream& stream) {
  const WorldParameters& world = parameters.world;
  const Kind kind = drawn_kind(parameters.proposal, stream);
  const double scale = scales.empty() ? 1 : scales[static_cast<std::size_t>(kind)];
  sampling::Proposal<State> proposal{.candidate = state, .kind = static_cast<std::uint32_t>(kind)};
  State& candidate = proposal.candidate;
  switch (kind) {
    case Kind::change_all:
      candidate = draw_state(world, stream);
      proposal.log_q_ratio = log_density_of(world, state) - log_density_of(world, candidate);
      break;
    case Kind::change_die: {
      const std::size_t die = drawn_die(state, stream);
      candidate.dice[die] = draw_throw(world.dice[die], stream);
      proposal.log_q_ratio = log_density_of(world.dice[die], state.dice[die]) -
                             log_density_of(world.dice[die], candidate.dice[die]);
      break;
    }
    case Kind::change_start:
      change_start(parameters, scale, candidate, stream);
      break;
    case Kind::change_control:
      change_field(parameters, drawn_control(world.table, stream), scale, candidate, stream);
      break;
    case Kind::change_contact: {
      const ContactShare* contact = drawn_contact(contacts, stream);
      if (contact == nullptr) break;
      change_field(parameters, contact->index, scale, candidate, stream);
      if (candidate == state) break;
      proposal.log_q_ratio = math::log(k_share_max) - math::log(contact->share);
      proposal.ratio_waits = true;
      break;
    }
  }
  return proposal;
}

double contact_log_q_ratio(const State& state, const ContactShares& contacts,
                           const State& candidate, const ContactShares& candidate_contacts) {
  // If an override equalled the key's own value, it would also count as a difference. This doesn't
  // occur here.
  const std::vector<GridIndex> changed = differences(state.overrides, candidate.overrides);
  CHECK_EQ(changed.size(), 1U);
  const double back = share_of(candidate_contacts, changed.front());
  if (back == 0) return k_impossible;
  return math::log(back) - math::log(share_of(contacts, changed.front()));
}

}  // namespace sleight::worlds::dice
