// Bodies that start at rest: what they touch, and whether contact forces hold them.
//
// Idea. All bodies that start at rest are placed first. Then their contacts are found, with the
// tolerance k_at_rest_gap_m and without a simulation. Contacts are corners near faces, and points
// where edges of such faces cross. If there are no such contacts, the closest points are used.
// Bodies connected by contacts form a structure. One system of contact forces must hold the whole
// structure (force_balance.h). The contact forces determine which body supports which.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/math/vector.h"
#include "worker/physics/collision/piece_corners.h"
#include "worker/physics/contact/force_balance.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/simulator/engine_options.h"
#include "worker/physics/simulator/world.h"

namespace sleight::physics {
namespace {

using math::dot;
using math::norm;

/// At this friction, no body slides; bodies may still topple or fall. Error messages report whether
/// such friction would help.
constexpr double k_rough = 1e3;
/// Maximum number of partners that an error message names.
constexpr std::size_t k_named = 4;

}  // namespace

struct World::RestTouch {
  BodyId body;  ///< body of the record
  TouchRecord record;
  StaticId static_index{};  ///< for error messages
};

void World::find_rest_touches(BodyId body, std::vector<RestTouch>& found,
                              std::optional<SceneError>& error) {
  const Tick tick{};
  const Vec3 centre_m = bodies_.position_at(body, tick);
  const auto overlaps = [&](double gap_m, const std::string& other) {
    if (gap_m >= -k_at_rest_gap_m) return false;
    error = SceneError{SceneError::Kind::overlap,
                       fmt::format("{} can't start at rest: it overlaps {} by {:.3g} m",
                                   bodies_.name(body), other, -gap_m)};
    return true;
  };
  const auto add = [&](const TouchRecord& touch, StaticId static_index) {
    const std::size_t before = found.size();
    if (!bodies_.is_sphere(body) &&
        (touch.partner == k_static_partner || !bodies_.constants(touch.partner).is_sphere)) {
      corners_like(body, touch, tick, 2 * k_at_rest_gap_m, [&](const TouchRecord& corner) {
        found.push_back({body, corner, static_index});
      });
    }
    if (found.size() == before) found.push_back({body, touch, static_index});
  };
  // If one face lies on another at an angle, corners alone are too few contacts. So add the points
  // where the faces' edges cross.
  const auto add_crossings = [&](const MovingPiece& own, const MovingPiece& other,
                                 TouchRecord touch, StaticId static_index) {
    const Vec3 normal = touch.normal;
    for_each_crossing(own, other, normal, dot(normal, centre_m + touch.arm_m), 2 * k_at_rest_gap_m,
                      [&](const Vec3& at_m) {
                        touch.arm_m = at_m - centre_m;
                        // Skip a crossing that was found before: triangles of a mesh share edges.
                        const bool known = std::ranges::any_of(found, [&](const RestTouch& one) {
                          return one.body == body && one.record.partner == touch.partner &&
                                 norm(one.record.arm_m - touch.arm_m) <= 2 * k_at_rest_gap_m;
                        });
                        if (!known) found.push_back({body, touch, static_index});
                      });
  };

  std::vector<StaticId> near;
  statics_.near(
      body,
      path_box(bodies_.path(body), bodies_.reach_m(body) + 2 * k_at_rest_gap_m, tick, tick + 1),
      near);
  for (const StaticId met : near) {
    TouchRecord touch{.tick = tick, .partner = k_static_partner, .feature = met};
    if (bodies_.is_sphere(body)) {
      const SphereFeature& feature = statics_.geometry().feature({met});
      const double gap_m =
          gap_between(feature, bodies_.centre_at(body, tick), bodies_.reach_m(body)).gap_m;
      if (!is_inside(statics_.geometry().sides(feature), centre_m) || gap_m > k_at_rest_gap_m)
        continue;
      if (overlaps(gap_m, statics_.geometry().name_of_feature({met}))) return;
      touch.normal = normal_at(feature, centre_m);
      touch.arm_m = -bodies_.reach_m(body) * touch.normal;
      touch.friction = statics_.law(body, met, centre_m + touch.arm_m).friction;
      add(touch, met);
      continue;
    }
    for (std::uint32_t part = 0; part < bodies_.constants(body).part_count; ++part) {
      const PieceContact contact = statics_.contact_of_part(met, body, part, tick);
      if (contact.gap_m > k_at_rest_gap_m) continue;
      if (overlaps(contact.gap_m, statics_.name(body, met))) return;
      touch.normal = contact.normal;
      touch.arm_m = contact.point_m - centre_m;
      touch.friction = statics_.law(body, met, contact.point_m).friction;
      add(touch, met);
      if (!statics_.is_surface(body, met) && met >= statics_.geometry().plane_count())
        add_crossings(bodies_.part_at(body, part, tick), statics_.geometry().piece({met}), touch,
                      met);
    }
  }

  for (BodyId other{}; other < bodies_.size(); ++other) {
    const bool carries = bodies_.is_fixed(other) || (scene().bodies[other].rests && other < body);
    if (!carries || !bodies_.may_meet(body, other)) continue;
    const Vec3 between_m = centre_m - bodies_.position_at(other, tick);
    if (norm(between_m) > bodies_.reach_m(body) + bodies_.reach_m(other) + k_at_rest_gap_m)
      continue;
    for (std::uint32_t i = 0; i < bodies_.constants(other).part_count; ++i) {
      for (std::uint32_t j = 0; j < bodies_.constants(body).part_count; ++j) {
        const MovingPiece of_other = bodies_.part_at(other, i, tick);
        const MovingPiece own = bodies_.part_at(body, j, tick);
        const PieceContact contact = contact_of(of_other, own);
        if (contact.gap_m > k_at_rest_gap_m) continue;
        if (overlaps(contact.gap_m, bodies_.name(other))) return;
        const TouchRecord touch{.tick = tick,
                                .partner = other,
                                .friction = scene()
                                                .contacts
                                                .between(bodies_.constants(other).material,
                                                         bodies_.constants(body).material)
                                                .friction,
                                .normal = contact.normal,
                                .arm_m = contact.point_m - centre_m};
        add(touch, {});
        add_crossings(own, of_other, touch, {});
      }
    }
  }
}

/// Returns the error if bodies can't start at rest. `body` is the least balanced body.
SceneError World::error_of_rest(BodyId body, double missing, bool holds_if_rough,
                                const std::vector<RestTouch>& touches) const {
  std::vector<std::string> partners;
  for (const RestTouch& touch : touches) {
    std::string partner;
    if (touch.body == body) {
      partner = touch.record.partner == k_static_partner ? statics_.name(body, touch.static_index)
                                                         : bodies_.name(touch.record.partner);
    } else if (touch.record.partner == body) {
      partner = bodies_.name(touch.body);
    } else {
      continue;
    }
    if (std::ranges::find(partners, partner) == partners.end()) partners.push_back(partner);
  }
  std::string message;
  if (partners.empty()) {
    message = fmt::format(
        "{} can't start at rest: neither static geometry nor another body that rests or is fixed "
        "is "
        "within {} m; put the body on a support, or start it slightly above one",
        bodies_.name(body), k_at_rest_gap_m);
  } else {
    const std::size_t named = std::min(partners.size(), k_named);
    message = fmt::format(
        "{} can't start at rest: the supports ({}{}) can't hold the body, so it would {}; {:.2g} "
        "of the forces on the body are not balanced",
        bodies_.name(body),
        fmt::join(partners.begin(), partners.begin() + static_cast<int>(named), ", "),
        partners.size() > named ? ", ..." : "",
        holds_if_rough ? "slide because friction is too small" : "topple or fall", missing);
  }
  return {SceneError::Kind::no_balance, std::move(message)};
}

std::optional<SceneError> World::lay_down() {
  for (const BodyId body : bodies_.fixed())
    place(body, segment_at_rest(body));
  std::vector<BodyId> resting;
  for (BodyId body{}; body < bodies_.size(); ++body) {
    if (scene().bodies[body].rests) resting.push_back(body);
  }
  if (resting.empty()) return {};
  for (const BodyId body : resting)
    place(body, segment_at_rest(body));
  std::vector<RestTouch> touches;
  std::optional<SceneError> error;
  for (const BodyId body : resting) {
    find_rest_touches(body, touches, error);
    if (error) return error;
  }

  // Find connected bodies. Each structure's root is its body with the lowest id.
  std::vector<BodyId> root(bodies_.size());
  for (BodyId body{}; body < bodies_.size(); ++body)
    root[body] = body;
  const auto find = [&](BodyId body) {
    while (root[body] != body)
      body = root[body] = root[root[body]];
    return body;
  };
  for (const RestTouch& touch : touches) {
    if (is_static(touch.record.partner)) continue;
    const BodyId a = find(touch.body);
    const BodyId b = find(touch.record.partner);
    root[std::max(a, b)] = std::min(a, b);
  }
  at_rest_.assign(bodies_.size(), {});
  for (const BodyId first : resting) {
    if (find(first) != first) continue;
    std::vector<BodyId> members;
    for (const BodyId body : resting) {
      if (find(body) == first) members.push_back(body);
    }
    if (auto wrong = lay_down_structure(members, touches)) return wrong;
  }
  return {};
}

std::optional<SceneError> World::lay_down_structure(std::span<const BodyId> members,
                                                    const std::vector<RestTouch>& touches) {
  if (members.size() > k_at_rest_together_max) {
    return SceneError{
        SceneError::Kind::no_balance,
        fmt::format("{} can't start at rest: it is connected with {} other bodies at rest; the "
                    "maximum is {}",
                    bodies_.name(members.front()), members.size() - 1, k_at_rest_together_max - 1)};
  }
  const auto place_of = [&](BodyId body) {
    return static_cast<std::uint32_t>(std::ranges::lower_bound(members, body) - members.begin());
  };
  const auto centre_m = [&](BodyId body) { return bodies_.position_at(body, Tick{}); };
  std::vector<HeldBody> held;
  for (const BodyId body : members)
    held.push_back({.weight_n = bodies_.constants(body).inertia.mass_kg * scene().gravity_mps2,
                    .reach_m = bodies_.constants(body).reach_m});
  std::vector<HoldingContact> contacts;
  std::vector<const RestTouch*> of_contact;
  for (const RestTouch& touch : touches) {
    if (!std::ranges::binary_search(members, touch.body)) continue;
    const TouchRecord& record = touch.record;
    HoldingContact contact{.body = place_of(touch.body),
                           .friction = record.friction,
                           .normal = record.normal,
                           .arm_m = record.arm_m};
    if (!is_static(record.partner)) {
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

  // Process the greatest forces first: a body stores only a limited number of its contacts.
  std::vector<std::size_t> order(contacts.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t c) { return -norm(balance.force_n(c)); });
  const Vec3 up = -math::normalized(scene().gravity_mps2);
  for (const std::size_t c : order) {
    const RestTouch& touch = *of_contact[c];
    const Vec3 force_n = balance.force_n(c);
    const double size_n = norm(force_n);
    const auto keep = [&](BodyId body, const TouchRecord& record, bool leans) {
      AtRest& at = at_rest_[body];
      if (at.touches.size() < k_touch_records_max) at.touches.push_back(record);
      if (leans && !is_static(record.partner) && at.supporters.size() < k_touch_records_max &&
          std::ranges::find(at.supporters, record.partner) == at.supporters.end())
        at.supporters.push_back(record.partner);
    };
    const double weight_n = norm(held[contacts[c].body].weight_n);
    const bool carries = size_n > k_carries_share * weight_n;
    const double rises = dot(force_n, up);
    const bool thrusts = norm(force_n - rises * up) > k_thrust_share * size_n;
    keep(touch.body, touch.record, carries && (thrusts || rises > 0));
    if (is_static(touch.record.partner)) continue;
    TouchRecord mirrored = touch.record;
    mirrored.partner = touch.body;
    mirrored.normal = -mirrored.normal;
    mirrored.arm_m = contacts[c].partner_arm_m;
    keep(touch.record.partner, mirrored, carries && (thrusts || rises < 0));
  }
  return {};
}

Segment World::segment_at_rest(BodyId body) const {
  Segment segment = bodies_.segment_of_start(scene().bodies[body].start, Tick{});
  segment.flight.acceleration_mps2 = Vec3::Zero();
  segment.mode = MotionMode::resting;
  return segment;
}

void World::begin_at_rest(BodyId body) {
  recorder_.learns(body);
  resting_.lies(body, bodies_.position_at(body, Tick{}), at_rest_[body].touches,
                at_rest_[body].supporters);
}

}  // namespace sleight::physics
