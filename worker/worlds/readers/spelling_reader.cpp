#include "worker/worlds/readers/spelling_reader.h"

#include <utility>
#include <vector>

#include "common/base/check.h"
#include "common/math/elementary.h"
#include "worker/physics/simulator/segment.h"
#include "worker/sampling/blind_throws.h"
#include "worker/worlds/readers/played_out.h"
#include "worker/worlds/segments/segment_values.h"
#include "worker/worlds/spelling/spelling.h"

namespace sleight::worlds::spelling {
namespace {

/// What archives say of each segment of a kept animation.
std::vector<archive::Variable> segment_columns() {
  const archive::Dimension xyz{.name = "axis_xyz", .size = 3};
  const archive::Dimension quaternion{.name = "quaternion_wxyz", .size = 4};
  return {
      {.name = "moving_ball", .dims = {}, .unit = "1", .meaning = "which ball moves"},
      {.name = "start_s", .dims = {}, .unit = "s", .meaning = "when the segment begins"},
      {.name = "mode", .dims = {}, .unit = "1", .meaning = "0 flies, 1 slides, 2 rolls, 3 rests"},
      {.name = "position_m",
       .dims = {xyz},
       .unit = "m",
       .meaning = "the ball's centre there, from the middle of the box on the floor's rim"},
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
       .meaning = "from the ball's frame to the box's at the segment's beginning"},
      {.name = "angular_velocity_radps",
       .dims = {xyz},
       .unit = "rad s-1",
       .meaning = "in the box's frame at the segment's beginning"},
      {.name = "angular_acceleration_radps2",
       .dims = {xyz},
       .unit = "rad s-2",
       .meaning = "in the box's frame all along"}};
}

archive::WorldLayout make_layout(const Spelling& world) {
  const archive::Dimension vertex{.name = "partition_vertex", .size = world.bins().vertex_count()};
  const archive::Dimension ball{.name = "ball", .size = world.balls()};
  const archive::Dimension xyz{.name = "axis_xyz", .size = 3};
  const archive::Dimension xy{.name = "axis_xy", .size = 2};
  return {.world = "spelling",
          .variables = {{.name = "vertex_offset_m",
                         .dims = {vertex, xyz},
                         .unit = "m",
                         .meaning = "how far each partition vertex is moved"},
                        {.name = "active",
                         .dims = {ball},
                         .unit = "1",
                         .meaning = "1 if the ball takes part, else 0"},
                        {.name = "drop_m",
                         .dims = {ball, xy},
                         .unit = "m",
                         .meaning = "where the ball is dropped, from the middle of the box; 0 if "
                                    "inactive"}},
          .outcomes =
              {{.name = "filled",
                .dims = {},
                .unit = "1",
                .meaning = "designated bins with a ball at rest, or in it for good"},
               {.name = "elsewhere",
                .dims = {},
                .unit = "1",
                .meaning = "active balls that fill no designated bin"},
               {.name = "end_s", .dims = {}, .unit = "s", .meaning = "when the simulation ended"},
               {.name = "end",
                .dims = {},
                .unit = "1",
                .meaning = "why it ended: 0 all at rest or in their bins for good, 1 time limit, 2 "
                           "no room to start, 3 the simulator could not go on"}},
          .proposal_kinds = {"change_all", "change_vertices", "change_ball", "disable_balls",
                             "enable_balls", "aim_ball", "scatter_ball", "solo_walk", "solo_step"},
          .segment_columns = segment_columns()};
}

class SpellingReader final : public archive::StateReader {
 public:
  explicit SpellingReader(const Parameters& parameters)
      : world_(parameters), layout_(make_layout(world_)) {
    if (parameters.proposal.kernel == Kernel::thesis)
      layout_.warning = "biased kernel: thesis (A.2.2 as printed)";
    // A throw has all balls in it; there are as many as bins to fill, so all that satisfy have.
    layout_.log_natural_throw = world_.balls() * math::log(0.5);
  }

  const archive::WorldLayout& layout() const override { return layout_; }

  std::vector<double> variables(base::BytesView state) const override {
    // The layout's variables are in the order of the bytes.
    return values_of(decoded(state));
  }

  double likeness_distance(base::BytesView a, base::BytesView b) const override {
    const std::vector<int> left = world_.balls_of_bins(decoded(a));
    const std::vector<int> right = world_.balls_of_bins(decoded(b));
    double unlike = 0;
    for (std::size_t bin = 0; bin < left.size(); ++bin)
      unlike += left[bin] != right[bin] ? 1 : 0;
    return unlike / static_cast<double>(world_.balls());
  }

  archive::Motion play(base::BytesView bytes) const override {
    const State state = decoded(bytes);
    const archive::PlaysOut ends = played_out(world_, world_.simulate_to_rest(state));
    if (ends != archive::PlaysOut::yes) return {.ends = ends, .recording = {}};
    const Animation animation = world_.animate(state);
    archive::Recording recording{.columns = 22, .values = {}};
    for (std::size_t body = 0; body < animation.balls.size(); ++body) {
      const auto id = physics::BodyId{static_cast<std::uint32_t>(body)};
      for (const auto& [segment, cause] : animation.recording.segments(id)) {
        recording.values.push_back(static_cast<double>(animation.balls[body]));
        append_segment(segment, segment.flight.orientation, recording.values);
        append_vector(segment.angular_acceleration_radps2, recording.values);
      }
    }
    return {.ends = ends, .recording = std::move(recording)};
  }

  std::vector<double> log_priors_of_throws(std::size_t count) const override {
    return sampling::log_priors_of_throws(
        world_, count, [&](random::Stream& stream) { return world_.draw_throw(stream); });
  }

 private:
  State decoded(base::BytesView bytes) const {
    auto state = world_.decode(bytes);
    CHECK(state.has_value());
    return *std::move(state);
  }

  Spelling world_;
  archive::WorldLayout layout_;
};

}  // namespace

std::unique_ptr<archive::StateReader> make_state_reader(const Parameters& parameters) {
  return std::make_unique<SpellingReader>(parameters);
}

}  // namespace sleight::worlds::spelling
