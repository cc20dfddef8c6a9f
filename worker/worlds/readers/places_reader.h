// The part that the readers of worlds with recorded bodies have in common. It compares animations
// by the places of their bodies (places_likeness.h).
//
// It caches the last requested animations, because the choice of kept animations compares each new
// animation with the same few animations. Thread-safe.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "worker/sampling/target.h"
#include "worker/worlds/readers/places_likeness.h"
#include "worker/worlds/readers/played_out.h"

namespace sleight::worlds {

template <class World>
class PlacesReader : public archive::StateReader {
 public:
  PlacesReader(World world, archive::WorldLayout layout, scene::Scene scene,
               PlacesLikeness likeness)
      : world_(std::move(world)),
        layout_(std::move(layout)),
        scene_(std::move(scene)),
        likeness_(std::move(likeness)) {}

  const archive::WorldLayout& layout() const override { return layout_; }
  const scene::Scene& scene() const override { return scene_; }

  std::vector<double> variables(base::BytesView bytes) const override {
    return values_of(decoded(world_, bytes));
  }
  std::vector<double> likeness(base::BytesView state) const override {
    const auto animation = animation_of(state);
    CHECK(animation->outcome.is_animation());
    const physics::Recording& recording = animation->recording;
    return likeness_.numbers(animation->outcome.collisions, recording.end(), centres_of(recording));
  }
  double likeness_distance(std::span<const double> a, std::span<const double> b) const override {
    return likeness_.distance(a, b);
  }
  bool is_unlike(std::span<const double> a, std::span<const double> b,
                 double distance) const override {
    return likeness_.distance(a, b, distance) > distance;
  }
  archive::Motion play(base::BytesView state) const override {
    const auto animation = animation_of(state);
    const archive::PlaysOut ends = played_out(world_, animation->outcome);
    if (ends != archive::PlaysOut::yes) return {.ends = ends};
    return {.segments = segments_of(*animation)};
  }
  std::vector<double> prior_draw(std::uint64_t nth) const override {
    return archive::prior_values(layout_, values_of(sampling::nth_prior_draw(world_, nth)));
  }
  std::vector<double> log_priors_of_throws(std::size_t count) const override {
    return sampling::log_priors_of_throws(
        world_, count, [&](random::Stream& stream) { return world_.draw_prior(stream); });
  }

 protected:
  using State = typename World::State;
  using Animation = decltype(std::declval<const World&>().animate(std::declval<const State&>()));

  /// Returns the values of all variables.
  virtual std::vector<double> values_of(const State& state) const = 0;
  virtual std::vector<motion::Segment> segments_of(const Animation& animation) const = 0;

  const World& world() const { return world_; }

 private:
  /// Several times the number stored per lineage. Uses a few megabytes for twenty dice.
  static constexpr std::size_t k_held = 16;
  struct Held {
    base::Bytes bytes;
    std::shared_ptr<const Animation> animation;
  };

  std::shared_ptr<const Animation> animation_of(base::BytesView bytes) const {
    {
      const std::lock_guard lock(mutex_);
      for (const Held& held : held_) {
        if (std::ranges::equal(held.bytes, bytes)) return held.animation;
      }
    }
    auto animation = std::make_shared<const Animation>(world_.animate(decoded(world_, bytes)));
    const std::lock_guard lock(mutex_);
    held_.push_back({base::Bytes(bytes.begin(), bytes.end()), animation});
    if (held_.size() > k_held) held_.pop_front();
    return animation;
  }

  World world_;
  archive::WorldLayout layout_;
  scene::Scene scene_;
  PlacesLikeness likeness_;
  mutable std::mutex mutex_;
  mutable std::deque<Held> held_;
};

}  // namespace sleight::worlds
