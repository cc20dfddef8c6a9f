// Checks the motions that state readers return. A reader of archives makes the same checks.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "common/archive/world_layout.h"
#include "common/motion/path.h"
#include "common/scene/scene.h"

namespace sleight::worlds::testing {

/// Returns a state's motion. Expects that the motion ends in the state's outcome, and that starts
/// and partners of hits are valid.
inline motion::Animation played(const archive::StateReader& reader, base::BytesView state) {
  const archive::Motion motion = reader.play(state);
  EXPECT_EQ(motion.ends, archive::PlaysOut::yes);
  const scene::Scene& scene = reader.scene();
  EXPECT_EQ(scene::fault_of(scene), "");
  for (const motion::Segment& segment : motion.segments) {
    const bool is_hit = segment.cause == motion::Cause::hit;
    EXPECT_EQ(is_hit, segment.partner != motion::k_no_partner);
    if (!is_hit) continue;
    const auto partner = static_cast<std::size_t>(segment.partner);
    EXPECT_LT(partner, scene.features.size());
    EXPECT_NE(scene.features.at(partner).kind, scene::FeatureKind::wanted);
    EXPECT_NE(partner, segment.body);
  }
  const auto animation = motion::Animation::of(motion.segments, scene.bodies());
  EXPECT_TRUE(animation.ok()) << (animation.ok() ? std::string() : animation.error());
  if (!animation) return {};
  for (const motion::Path& path : animation.value().paths()) {
    if (path.enters()) {
      EXPECT_EQ(path.segments().front().cause, motion::Cause::start);
    }
  }
  return animation.value();
}

/// Returns the distance of two states, computed from their compared data. Must agree with the quick
/// function.
inline double distance_by(const archive::StateReader& reader, base::BytesView a,
                          base::BytesView b) {
  const std::vector<double> left = reader.likeness(a);
  const std::vector<double> right = reader.likeness(b);
  const double distance = reader.likeness_distance(left, right);
  EXPECT_FALSE(reader.is_unlike(left, right, distance));
  EXPECT_TRUE(reader.is_unlike(left, right, std::nextafter(distance, -1.0)));
  return distance;
}

/// Expects that prior draws fit the layout, are the same at every call, and differ from each other.
inline void check_prior_draws(const archive::StateReader& reader) {
  std::size_t width = 0;
  for (const archive::Variable& variable : archive::prior_variables(reader.layout()))
    width += variable.size();
  for (std::uint64_t nth = 0; nth < 4; ++nth) {
    EXPECT_EQ(reader.prior_draw(nth).size(), width);
    EXPECT_EQ(reader.prior_draw(nth), reader.prior_draw(nth));
    EXPECT_NE(reader.prior_draw(nth), reader.prior_draw(nth + 1));
  }
  for (const archive::Variable& variable : reader.layout().variables) {
    EXPECT_TRUE(variable.prior_sd.empty() || variable.prior_sd.size() == variable.size());
    EXPECT_EQ(variable.prior_mean.size(), variable.prior_sd.size());
  }
}

}  // namespace sleight::worlds::testing
