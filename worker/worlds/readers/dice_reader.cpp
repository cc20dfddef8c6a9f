#include "worker/worlds/readers/dice_reader.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "common/base/check.h"
#include "common/math/elementary.h"
#include "worker/physics/simulator/segment.h"
#include "worker/sampling/blind_throws.h"
#include "worker/worlds/dice/dice.h"
#include "worker/worlds/readers/played_out.h"
#include "worker/worlds/segments/segment_values.h"

namespace sleight::worlds::dice {
namespace {

constexpr double k_likeness_every_s = 1.0 / 60;

std::vector<archive::Variable> variables_of(const Dice& world) {
  const archive::Dimension die{.name = "die", .size = world.dice()};
  const archive::Dimension xyz{.name = "axis_xyz", .size = 3};
  const archive::Dimension quaternion{.name = "quaternion_wxyz", .size = 4};
  const archive::Dimension half{.name = "half", .size = 2};
  return {{.name = "table_key",
           .dims = {half},
           .unit = "1",
           .meaning = "the upper and the lower 32 bits of the number that the table is made from"},
          {.name = "changed_points",
           .dims = {},
           .unit = "1",
           .meaning = "how many control points of the table are not those of its key"},
          {.name = "start_position_m",
           .dims = {die, xyz},
           .unit = "m",
           .meaning = "the die's centre when it is let go"},
          {.name = "start_orientation",
           .dims = {die, quaternion},
           .unit = "1",
           .meaning = "then, from the unnumbered cube's frame to the table's"},
          {.name = "start_velocity_mps", .dims = {die, xyz}, .unit = "m s-1", .meaning = "then"},
          {.name = "start_spin_radps",
           .dims = {die, xyz},
           .unit = "rad s-1",
           .meaning = "angular velocity then, in the table's frame"}};
}

std::vector<archive::Variable> outcomes_of(const Parameters& parameters) {
  std::vector<archive::Variable> outcomes{
      {.name = "end",
       .dims = {},
       .unit = "1",
       .meaning = "why it ended: 0 all at rest, 1 time limit, 2 no room to start, or the simulator "
                  "could not go on"},
      {.name = "end_s", .dims = {}, .unit = "s", .meaning = "when the last die came to rest"},
      {.name = "collisions",
       .dims = {},
       .unit = "1",
       .meaning = "collisions of dice with the table"},
      {.name = "log_plausibility",
       .dims = {},
       .unit = "1",
       .meaning = "log p_w of the control points that these hung on"},
      {.name = "offset_squares",
       .dims = {},
       .unit = "1",
       .meaning = "sum of the squares of those points' heights, in standard deviations"},
      {.name = "offsets",
       .dims = {{.name = "offset_bin", .size = k_offset_bins}},
       .unit = "1",
       .meaning = fmt::format("how many of those points have such a height: below {} standard "
                              "deviations, in steps of {} from there, above the last",
                              k_offset_first_sd, k_offset_step_sd)}};
  for (std::size_t i = 0; i < parameters.goals.size(); ++i) {
    const Goal& goal = parameters.goals[i];
    const std::string unit = unit_of(goal);
    outcomes.push_back({.name = fmt::format("goal_{}_{}_{}", i + 1, name_of(goal), unit),
                        .dims = {},
                        .unit = unit == "mps" ? "m s-1" : unit,
                        .meaning = fmt::format("how far die {} is from this goal", goal.die + 1)});
  }
  return outcomes;
}

archive::WorldLayout make_layout(const Dice& world) {
  const archive::Dimension xyz{.name = "axis_xyz", .size = 3};
  const archive::Dimension quaternion{.name = "quaternion_wxyz", .size = 4};
  archive::WorldLayout layout{
      .world = "dice",
      .variables = variables_of(world),
      .outcomes = outcomes_of(world.parameters()),
      .proposal_kinds = {"change_all", "change_die", "change_start", "change_control",
                         "change_contact"},
      .segment_columns = {
          {.name = "moving_die", .dims = {}, .unit = "1", .meaning = "which die moves, from 0"},
          {.name = "start_s", .dims = {}, .unit = "s", .meaning = "when the segment begins"},
          {.name = "mode", .dims = {}, .unit = "1", .meaning = "0 flies, 3 rests"},
          {.name = "position_m",
           .dims = {xyz},
           .unit = "m",
           .meaning = "the die's centre there, from the middle of the table"},
          {.name = "velocity_mps",
           .dims = {xyz},
           .unit = "m s-1",
           .meaning = "the centre's velocity just after the segment's first instant"},
          {.name = "acceleration_mps2",
           .dims = {xyz},
           .unit = "m s-2",
           .meaning = "the centre's acceleration all along"},
          {.name = "orientation",
           .dims = {quaternion},
           .unit = "1",
           .meaning = "from the numbered die's frame (1 on +x, 2 on +y, 3 on +z) to the table's at "
                      "the segment's beginning"},
          {.name = "angular_velocity_radps",
           .dims = {xyz},
           .unit = "rad s-1",
           .meaning = "in the table's frame, all along"}}};
  if (world.parameters().numbering == Numbering::free) {
    for (std::uint32_t die = 0; die < world.dice(); ++die) {
      layout.log_natural_throw +=
          math::log(double{k_numberings} / numberings_that_meet(world.parameters().goals, die));
    }
  }
  return layout;
}

/// The animations that were asked for last: the choice of kept animations compares each one with
/// the same few others. Thread-safe.
class LastAnimations {
 public:
  std::shared_ptr<const Animation> of(const Dice& world, base::BytesView bytes) {
    {
      const std::lock_guard lock(mutex_);
      for (const Held& held : held_) {
        if (std::ranges::equal(held.bytes, bytes)) return held.animation;
      }
    }
    const auto state = world.decode(bytes);
    CHECK(state.has_value());
    auto animation = std::make_shared<const Animation>(world.animate(*state));
    const std::lock_guard lock(mutex_);
    if (held_.size() < k_held) held_.emplace_back();
    held_[next_] = {base::Bytes(bytes.begin(), bytes.end()), animation};
    next_ = (next_ + 1) % k_held;
    return animation;
  }

 private:
  /// Some times as many as are kept of a lineage; of twenty dice they take some megabytes.
  static constexpr std::size_t k_held = 16;
  struct Held {
    base::Bytes bytes;
    std::shared_ptr<const Animation> animation;
  };
  std::mutex mutex_;
  std::vector<Held> held_;
  std::size_t next_ = 0;
};

class DiceReader final : public archive::StateReader {
 public:
  explicit DiceReader(const Parameters& parameters)
      : world_(parameters), layout_(make_layout(world_)) {}

  const archive::WorldLayout& layout() const override { return layout_; }

  std::vector<double> variables(base::BytesView bytes) const override {
    const State state = decoded(bytes);
    std::vector<double> values{static_cast<double>(state.table_key >> 32U),
                               static_cast<double>(state.table_key & 0xffffffffU),
                               static_cast<double>(state.overrides.size())};
    for (const DieThrow& die : state.dice)
      append_vector(die.position_m, values);
    for (const DieThrow& die : state.dice)
      append_quaternion(die.orientation, values);
    for (const DieThrow& die : state.dice)
      append_vector(die.velocity_mps, values);
    for (const DieThrow& die : state.dice)
      append_vector(die.spin_radps, values);
    return values;
  }

  double likeness_distance(base::BytesView a, base::BytesView b) const override {
    const auto one_throw = animations_.of(world_, a);
    const auto other_throw = animations_.of(world_, b);
    CHECK(one_throw->outcome.is_animation() && other_throw->outcome.is_animation());
    const physics::Recording& left = one_throw->recording;
    const physics::Recording& right = other_throw->recording;
    const physics::TickCount step = physics::ticks_after(k_likeness_every_s);
    double most_m = 0;
    for (std::uint32_t die = 0; die < world_.dice(); ++die) {
      for (physics::Tick t{}; t <= std::max(left.end(), right.end()); t = t + step) {
        const auto one = place_at(left, {die}, t);
        const auto other = place_at(right, {die}, t);
        if (one && other) most_m = std::max(most_m, math::norm(Vec3(*one - *other)));
      }
    }
    const double left_touches = one_throw->outcome.collisions;
    const double right_touches = other_throw->outcome.collisions;
    const double more = std::max({left_touches, right_touches, 1.0});
    return most_m / world_.parameters().world.side_m +
           std::fabs(left_touches - right_touches) / more;
  }

  archive::Motion play(base::BytesView state) const override {
    const auto animation = animations_.of(world_, state);
    const archive::PlaysOut ends = played_out(world_, animation->outcome);
    if (ends != archive::PlaysOut::yes) return {.ends = ends, .recording = {}};
    archive::Recording recording{.columns = 19, .values = {}};
    for (std::uint32_t die = 0; die < world_.dice(); ++die) {
      const Quat numbered = rotation_of_numbering(animation->outcome.judgement.numberings[die]);
      for (const auto& [segment, cause] : animation->recording.segments({die})) {
        recording.values.push_back(die);
        append_segment(segment, math::composed(segment.flight.orientation, numbered),
                       recording.values);
      }
    }
    return {.ends = ends, .recording = std::move(recording)};
  }

  std::vector<double> log_priors_of_throws(std::size_t count) const override {
    return sampling::log_priors_of_throws(
        world_, count, [&](random::Stream& stream) { return world_.draw_prior(stream); });
  }

 private:
  State decoded(base::BytesView bytes) const {
    auto state = world_.decode(bytes);
    CHECK(state.has_value());
    return *std::move(state);
  }

  /// Where it was last, after the recording's end; nothing before the die has started.
  static std::optional<Vec3> place_at(const physics::Recording& recording, physics::BodyId die,
                                      physics::Tick tick) {
    const physics::Tick known = std::min(tick, recording.end());
    const physics::Segment* segment = recording.segment_at(die, known);
    if (segment == nullptr) return std::nullopt;
    return physics::position_at(segment->flight, known);
  }

  Dice world_;
  archive::WorldLayout layout_;
  mutable LastAnimations animations_;
};

}  // namespace

std::unique_ptr<archive::StateReader> make_state_reader(const Parameters& parameters) {
  return std::make_unique<DiceReader>(parameters);
}

}  // namespace sleight::worlds::dice
