#include "worker/physics/simulator/world.h"

#include <fmt/format.h>

#include <algorithm>

#include "worker/physics/contact/lasting_contact.h"
#include "worker/physics/event/tolerances.h"

namespace sleight::physics {
namespace {

/// Noised impacts of a body with this many partners are counted without allocation.
constexpr std::size_t k_partners_reserved = 16;

}  // namespace

World::World(const Scene& scene, bool record, std::size_t segments_reserved)
    : bodies_(scene),
      statics_(bodies_),
      predictions_(bodies_, statics_, scene.slow.separation_speed_mps > 0),
      recorder_(scene.bodies.size(), record, segments_reserved) {
  const std::size_t count = scene.bodies.size();
  const SlowContacts& slow = scene.slow;
  const double pull_mps2 = math::norm(scene.gravity_mps2);
  if (slow.separation_speed_mps > 0 && statics_.geometry().feature_count() > 0) {
    bodies_.let_stay();
    has_modes_ = true;
    if (pull_mps2 > 0)
      alone_for_ = ticks_after(k_bounces_alone * 2 * slow.separation_speed_mps / pull_mps2);
  }
  has_modes_ = has_modes_ || std::ranges::any_of(scene.bodies, [](const BodyDescription& body) {
                 return !body.fixed && body.inertia.symmetry == InertiaSymmetry::general;
               });
  const double bounce_s = pull_mps2 > 0 ? 2 * slow.separation_speed_mps / pull_mps2 : 1;
  std::vector<RestingBody> resting;
  resting.reserve(count);
  for (BodyId body{}; body < count; ++body) {
    const BodyConstants& constants = bodies_.constants(body);
    resting.push_back({.weight_n = constants.inertia.mass_kg * scene.gravity_mps2,
                       .reach_m = constants.reach_m,
                       .round = constants.is_sphere,
                       .fixed = constants.fixed});
  }
  resting_.reset(resting, slow, ticks_after(k_jam_bounces * bounce_s));
  replayed_.reset(count);
  changed_.reserve(count);
  collided_.resize(count);
  if (scene.noise.is_on()) {
    noised_.resize(count);
    for (std::vector<PairCount>& pairs : noised_)
      pairs.reserve(k_partners_reserved);
  }
  if (only_flies() && !scene.noise.is_on() && scene.contacts.materials() == 1 &&
      scene.contacts.between({}, {}).friction == 0) {
    for (BodyId body{}; body < count; ++body)
      plain_inverse_masses_per_kg_.push_back(
          bodies_.constants(body).sphere_mass.inverse_mass_per_kg);
  }
}

const std::optional<SceneError>& World::failure() {
  if (!failure_ && predictions_.gave_up()) {
    const Predictions::GaveUp& first = *predictions_.gave_up();
    failure_ = SceneError{SceneError::Kind::search_gave_up,
                          message_of("collision search gave up", first.body, first.tick)};
  }
  return failure_;
}

void World::note_failure(SceneError::Kind kind, const std::string& what, BodyId body, Tick tick) {
  if (!failure()) failure_ = SceneError{kind, message_of(what, body, tick)};
}

std::string World::message_of(const std::string& what, BodyId body, Tick tick) const {
  return fmt::format("{}: {} at tick {} ({:.9g} s)", bodies_.name(body), what, tick.value,
                     seconds(tick - Tick{}));
}

void World::place(BodyId body, const Segment& segment) {
  predictions_.moved();
  bodies_.place(body, segment);
}

void World::begin_segment(BodyId body, const Segment& segment, const EventKey& cause) {
  predictions_.moved();
  bodies_.begin(body, segment);
  predictions_.began(body);
  recorder_.begins(body, bodies_.segment(body), cause);
}

}  // namespace sleight::physics
