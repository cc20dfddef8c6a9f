// Bodies that start at rest: what they touch, and whether contact forces hold them there.
//
// Idea. All of them are put in their places first. What touches is found with the tolerance
// k_at_rest_gap_m, without a simulation: corners near faces, or else the closest points. Bodies
// that hang together by such contacts make a structure; one system of contact forces must hold it
// (force_balance.h). Who is carried by whom follows from these forces.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/math/vector.h"
#include "worker/physics/contact/force_balance.h"
#include "worker/physics/simulator/engine_options.h"
#include "worker/physics/simulator/world.h"

namespace sleight::physics {
namespace {

using math::dot;
using math::norm;

/// A force that leans to the side by more than this part of itself is one that both need.
constexpr double k_thrust = 0.05;
/// Of the weight: forces below this carry nothing.
constexpr double k_carries = 1e-3;
/// With so much friction only what would topple or fall isn't held.
constexpr double k_rough = 1e3;
/// Partners that an error names.
constexpr std::size_t k_named = 4;

}  // namespace

/// Two bodies that touch, or a body and static geometry.
struct World::RestTouch {
  std::uint32_t body;  ///< of the record
  TouchRecord record;
  std::uint32_t static_index = 0;  ///< for people
};

void World::find_rest_touches(std::uint32_t body, std::vector<RestTouch>& found,
                              std::optional<SceneError>& error) {
  const Tick tick{};
  const Vec3 centre_m = position_at(segments_[body].flight, tick);
  const auto overlaps = [&](double gap_m, const std::string& other) {
    if (gap_m >= -k_at_rest_gap_m) return false;
    error = SceneError{SceneError::Kind::overlap,
                       fmt::format("{} can't start at rest: it overlaps {} by {:.3g} m", name(body),
                                   other, -gap_m)};
    return true;
  };
  const auto add = [&](const TouchRecord& touch, std::uint32_t static_index) {
    const std::size_t before = found.size();
    if (!constants_[body].is_sphere &&
        (touch.partner == k_static_partner || !constants_[touch.partner].is_sphere)) {
      corners_like(body, touch, tick, 2 * k_at_rest_gap_m, [&](const TouchRecord& corner) {
        found.push_back({body, corner, static_index});
      });
    }
    if (found.size() == before) found.push_back({body, touch, static_index});
  };

  std::vector<std::uint32_t> near;
  statics_near(body, path_box(path(body), reach_m(body) + 2 * k_at_rest_gap_m, tick, tick + 1),
               near);
  for (const std::uint32_t index : near) {
    TouchRecord touch{.tick = tick, .partner = k_static_partner, .feature = index};
    if (constants_[body].is_sphere) {
      const SphereFeature& feature = statics_.feature(index);
      const double gap_m = gap_between(feature, centre_at(body, tick), reach_m(body)).gap_m;
      if (!is_inside(statics_.sides(feature), centre_m) || gap_m > k_at_rest_gap_m) continue;
      if (overlaps(gap_m, statics_.name_of_feature(index))) return;
      touch.normal = normal_at(feature, centre_m);
      touch.arm_m = -reach_m(body) * touch.normal;
      touch.friction = law_of_static(body, index, centre_m + touch.arm_m).friction;
      add(touch, index);
      continue;
    }
    for (std::uint32_t part = 0; part < constants_[body].part_count; ++part) {
      const PieceContact contact = contact_with_static(index, body, part, tick);
      if (contact.gap_m > k_at_rest_gap_m) continue;
      if (overlaps(contact.gap_m, static_name(body, index))) return;
      touch.normal = contact.normal;
      touch.arm_m = contact.point_m - centre_m;
      touch.friction = law_of_static(body, index, contact.point_m).friction;
      add(touch, index);
    }
  }

  for (std::uint32_t other = 0; other < body; ++other) {
    if (!scene_.bodies[other].rests) continue;
    const Vec3 between_m = centre_m - position_at(segments_[other].flight, tick);
    if (norm(between_m) > reach_m(body) + reach_m(other) + k_at_rest_gap_m) continue;
    for (std::uint32_t i = 0; i < constants_[other].part_count; ++i) {
      for (std::uint32_t j = 0; j < constants_[body].part_count; ++j) {
        const PieceContact contact = contact_of(part_at(other, i, tick), part_at(body, j, tick));
        if (contact.gap_m > k_at_rest_gap_m) continue;
        if (overlaps(contact.gap_m, name(other))) return;
        add({.tick = tick,
             .partner = other,
             .friction =
                 scene_.contacts.between(constants_[other].material, constants_[body].material)
                     .friction,
             .normal = contact.normal,
             .arm_m = contact.point_m - centre_m},
            0);
      }
    }
  }
}

/// Why a structure doesn't hold, of the body that misses most of its balance.
SceneError World::error_of_rest(std::uint32_t body, double missing, bool holds_if_rough,
                                const std::vector<RestTouch>& touches) const {
  std::vector<std::string> partners;
  for (const RestTouch& touch : touches) {
    std::string partner;
    if (touch.body == body) {
      partner = touch.record.partner == k_static_partner ? static_name(body, touch.static_index)
                                                         : name(touch.record.partner);
    } else if (touch.record.partner == body) {
      partner = name(touch.body);
    } else {
      continue;
    }
    if (std::ranges::find(partners, partner) == partners.end()) partners.push_back(partner);
  }
  std::string message;
  if (partners.empty()) {
    message = fmt::format(
        "{} can't start at rest: it touches neither static geometry nor another body that starts "
        "at rest, to within {} m; put it on what is to carry it, or let it start a little above "
        "and come to rest",
        name(body), k_at_rest_gap_m);
  } else {
    const std::size_t named = std::min(partners.size(), k_named);
    message = fmt::format(
        "{} can't start at rest: what it touches ({}{}) can't hold it: it would {}; {:.2g} of the "
        "forces on it are not balanced",
        name(body), fmt::join(partners.begin(), partners.begin() + static_cast<int>(named), ", "),
        partners.size() > named ? ", ..." : "",
        holds_if_rough ? "slide, as friction is too small" : "topple or fall", missing);
  }
  return {SceneError::Kind::no_balance, std::move(message)};
}

std::optional<SceneError> World::lay_down() {
  std::vector<std::uint32_t> resting;
  for (std::uint32_t body = 0; body < size(); ++body) {
    if (scene_.bodies[body].rests) resting.push_back(body);
  }
  if (resting.empty()) return {};
  for (const std::uint32_t body : resting)
    place(body, segment_at_rest(body));
  std::vector<RestTouch> touches;
  std::optional<SceneError> error;
  for (const std::uint32_t body : resting) {
    find_rest_touches(body, touches, error);
    if (error) return error;
  }

  // Bodies that hang together, each by the least of its structure.
  std::vector<std::uint32_t> root(size());
  std::iota(root.begin(), root.end(), 0U);
  const auto find = [&](std::uint32_t body) {
    while (root[body] != body)
      body = root[body] = root[root[body]];
    return body;
  };
  for (const RestTouch& touch : touches) {
    if (touch.record.partner == k_static_partner) continue;
    const std::uint32_t a = find(touch.body);
    const std::uint32_t b = find(touch.record.partner);
    root[std::max(a, b)] = std::min(a, b);
  }
  at_rest_.assign(size(), {});
  for (const std::uint32_t first : resting) {
    if (find(first) != first) continue;
    std::vector<std::uint32_t> members;
    for (const std::uint32_t body : resting) {
      if (find(body) == first) members.push_back(body);
    }
    if (auto wrong = lay_down_structure(members, touches)) return wrong;
  }
  return {};
}

std::optional<SceneError> World::lay_down_structure(std::span<const std::uint32_t> members,
                                                    const std::vector<RestTouch>& touches) {
  if (members.size() > k_at_rest_together_max) {
    return SceneError{SceneError::Kind::no_balance,
                      fmt::format("{} can't start at rest: {} bodies hang together with it; {} may",
                                  name(members.front()), members.size(), k_at_rest_together_max)};
  }
  const auto place_of = [&](std::uint32_t body) {
    return static_cast<std::uint32_t>(std::ranges::lower_bound(members, body) - members.begin());
  };
  const auto centre_m = [&](std::uint32_t body) {
    return position_at(segments_[body].flight, Tick{});
  };
  std::vector<HeldBody> held;
  for (const std::uint32_t body : members)
    held.push_back({.weight_n = constants_[body].inertia.mass_kg * scene_.gravity_mps2,
                    .reach_m = constants_[body].reach_m});
  std::vector<HoldingContact> contacts;
  std::vector<const RestTouch*> of_contact;
  for (const RestTouch& touch : touches) {
    if (!std::ranges::binary_search(members, touch.body)) continue;
    const TouchRecord& record = touch.record;
    HoldingContact contact{.body = place_of(touch.body),
                           .friction = record.friction,
                           .normal = record.normal,
                           .arm_m = record.arm_m};
    if (record.partner != k_static_partner) {
      contact.partner = place_of(record.partner);
      contact.partner_arm_m = (centre_m(touch.body) + record.arm_m) - centre_m(record.partner);
    }
    contacts.push_back(contact);
    of_contact.push_back(&touch);
  }
  ForceBalance balance;
  if (!balance.holds(held, contacts)) {
    std::size_t worst = 0;
    for (std::size_t i = 1; i < members.size(); ++i) {
      if (balance.missing(i) > balance.missing(worst)) worst = i;
    }
    const double missing = balance.missing(worst);
    for (HoldingContact& contact : contacts)
      contact.friction = k_rough;
    return error_of_rest(members[worst], missing, balance.holds(held, contacts), touches);
  }

  // Greatest forces first: a body keeps some of its contacts.
  std::vector<std::size_t> order(contacts.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t c) { return -norm(balance.force_n(c)); });
  const Vec3 up = -math::normalized(scene_.gravity_mps2);
  for (const std::size_t c : order) {
    const RestTouch& touch = *of_contact[c];
    const Vec3 force_n = balance.force_n(c);
    const double size_n = norm(force_n);
    const auto keep = [&](std::uint32_t body, const TouchRecord& record, bool leans) {
      AtRest& at = at_rest_[body];
      if (at.touches.size() < Resting::k_records) at.touches.push_back(record);
      if (leans && record.partner != k_static_partner &&
          at.supporters.size() < Resting::k_records &&
          std::ranges::find(at.supporters, record.partner) == at.supporters.end())
        at.supporters.push_back(record.partner);
    };
    const double weight_n = norm(held[contacts[c].body].weight_n);
    const bool carries = size_n > k_carries * weight_n;
    const double rises = dot(force_n, up);
    const bool thrusts = norm(force_n - rises * up) > k_thrust * size_n;
    keep(touch.body, touch.record, carries && (thrusts || rises > 0));
    if (touch.record.partner == k_static_partner) continue;
    TouchRecord mirrored = touch.record;
    mirrored.partner = touch.body;
    mirrored.normal = -mirrored.normal;
    mirrored.arm_m = contacts[c].partner_arm_m;
    keep(touch.record.partner, mirrored, carries && (thrusts || rises < 0));
  }
  return {};
}

Segment World::segment_at_rest(std::uint32_t body) const {
  Segment segment = segment_of_start(scene_.bodies[body].start, Tick{});
  segment.flight.acceleration_mps2 = Vec3::Zero();
  segment.mode = MotionMode::resting;
  return segment;
}

void World::begin_at_rest(std::uint32_t body) {
  note_contact_state(body);
  resting_.lies(body, at_rest_[body].touches, at_rest_[body].supporters);
}

}  // namespace sleight::physics
