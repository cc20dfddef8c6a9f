// Measures the constraints of a scene in a simulation (constraints.h).
// Thread safety: const functions may be called from several threads at once.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "worker/physics/contact/impacts.h"
#include "worker/physics/reuse/recording.h"
#include "worker/worlds/user_scene/build.h"
#include "worker/worlds/user_scene/constraints.h"

namespace sleight::worlds::user_scene {

/// A moving body at a point in time.
struct BodyView {
  bool takes_part = true;  ///< has started
  bool rests = false;
  Pose place{};  ///< of the shape's frame
};
using Views = std::vector<BodyView>;  ///< by moving body

/// What constraints look at.
struct Watched {
  const physics::Scene& scene;         ///< as simulated
  const std::vector<Views>& at_times;  ///< at Judge::times_s()
  const Views& at_end;
  std::span<const physics::Impact> impacts;
  const physics::Recording* recording = nullptr;  ///< if Judge::needs_recording()
};

/// Constraints that are decided together, and before those of later stages.
struct Stage {
  /// A simulation up to here shows how far the stage's constraints are from being met.
  double until_s = 0;
  std::vector<std::uint32_t> constraints;
};

struct Judgement {
  double log_constraint = 0;
  bool all_met = true;
  /// Latest time at which a constraint was met. Nothing later changes what has been judged.
  double decided_s = 0;
  // By constraint. NaN and false: not judged.
  std::vector<double> distances{};  ///< in SI units
  std::vector<bool> met{};
};

class Judge {
 public:
  /// REQUIRES: all arguments outlive this object.
  Judge(const SceneDescription& description, const BuiltScene& built,
        std::span<const Constraint> constraints);

  /// Times at which constraints look, in ascending order.
  const std::vector<double>& times_s() const { return times_s_; }
  /// When the last constraint has looked. If `waits_for_rest`, the simulation goes on until all
  /// bodies have ended, but not beyond the scene's end_s.
  double last_s() const { return last_s_; }
  bool waits_for_rest() const { return waits_for_rest_; }
  bool needs_recording() const { return needs_recording_; }

  /// All constraints, in ascending order of time. The last stage has those that look at rest, at
  /// counts, or at no certain time; its until_s is last_s(). A scene without noise has one stage,
  /// because nothing can be changed after the start.
  const std::vector<Stage>& stages() const { return stages_; }

  /// Judges the constraints of the first `stages` stages. REQUIRES: the simulation went on to their
  /// until_s, or ended as last_s() describes if all stages are judged.
  Judgement judge(const Watched& watched, std::size_t stages) const;

 private:
  struct Measured {
    double distance = 0;
    bool can_be_met = true;
  };
  /// A hit's time, or nothing if there was none.
  using HitTime = std::optional<double>;

  void make_stages(bool has_noise);
  /// Returns the constraint's Stage::until_s; infinity if it belongs to the last stage.
  double until_s(const Constraint& constraint) const;
  Measured of_constraint(const Constraint& constraint, const Watched& watched,
                         std::span<const HitTime> hit_times, HitTime& time) const;
  Measured of_body(const Constraint& constraint, std::uint32_t body, const Watched& watched) const;
  Measured of_count(const Constraint& constraint, const Watched& watched) const;
  Measured of_event(const Constraint& constraint, std::uint32_t body, const Watched& watched,
                    HitTime& time) const;
  Measured of_order(const Constraint& constraint, std::span<const HitTime> hit_times) const;
  const BodyView& view(const Constraint& constraint, std::uint32_t body,
                       const Watched& watched) const;
  HitTime hit_time(const Constraint& constraint, std::uint32_t body, const Watched& watched) const;
  double least_gap_m(const Constraint& constraint, std::uint32_t body, double from_s, double to_s,
                     const Watched& watched) const;

  const BuiltScene& built_;
  std::span<const Constraint> constraints_;
  double end_s_;
  Vec3 up_;
  StaticOwners owners_;
  std::vector<Region> boxes_;  ///< by object
  std::vector<double> times_s_;
  double last_s_ = 0;
  bool waits_for_rest_ = false;
  bool needs_recording_ = false;
  std::vector<Stage> stages_;
};

}  // namespace sleight::worlds::user_scene
