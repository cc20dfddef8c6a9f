#include "worker/worlds/readers/readers.h"

#include <cstdint>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "common/base/check.h"
#include "common/math/elementary.h"
#include "worker/physics/scene/static_geometry.h"
#include "worker/worlds/readers/played_out.h"
#include "worker/worlds/scene_parts/scene_parts.h"
#include "worker/worlds/segments/recorded_segments.h"
#include "worker/worlds/spelling/spelling.h"

namespace sleight::worlds::spelling {
namespace {

archive::WorldLayout make_layout(const Spelling& world) {
  const archive::Dimension vertex{.name = "partition_vertex", .size = world.bins().vertex_count()};
  const archive::Dimension ball{.name = "ball", .size = world.balls()};
  const archive::Dimension xyz{.name = "axis_xyz", .size = 3};
  const archive::Dimension xy{.name = "axis_xy", .size = 2};
  return {
      .world = "spelling",
      .variables =
          {{.name = "vertex_offset_m",
            .dims = {vertex, xyz},
            .unit = "m",
            .meaning = "displacement of each partition vertex",
            .prior_mean = std::vector<double>(3 * vertex.size, 0),
            .prior_sd = std::vector<double>(3 * vertex.size, world.parameters().world.vertex_sd_m)},
           {.name = "active", .dims = {ball}, .meaning = "1 if the ball takes part, else 0"},
           {.name = "drop_m",
            .dims = {ball, xy},
            .unit = "m",
            .meaning = "place where the ball is dropped, relative to the middle of the "
                       "box; 0 if inactive"}},
      .outcomes = {{.name = "filled",
                    .meaning = "number of designated bins with a ball that rests or cannot leave"},
                   {.name = "elsewhere",
                    .meaning = "number of active balls that fill no designated bin"},
                   {.name = "end_s", .unit = "s", .meaning = "time at which the simulation ended"},
                   {.name = "end",
                    .meaning =
                        "why the simulation ended: 0 all balls at rest or unable to leave their "
                        "bins, 1 time limit, 2 no room to start, 3 the simulator failed"}},
      .proposal_kinds = {"change_all", "change_vertices", "change_ball", "disable_balls",
                         "enable_balls", "aim_ball", "scatter_ball", "solo_walk", "solo_step"}};
}

/// A state without offsets. All balls are dropped at the first designated bin.
State plain_state(const Spelling& world) {
  const auto vertices = world.bins().vertices_m().size();
  return {.offsets_m = std::vector<Vec3>(vertices, Vec3{0, 0, 0}),
          .active = std::vector<std::uint8_t>(world.balls(), 1),
          .drops_m = std::vector<Vec2>(world.balls(), world.middle_m(0))};
}

scene::Scene make_scene(const Spelling& world, const physics::Scene& simulated) {
  const WorldParameters& parameters = world.parameters().world;
  const double diameter_m = parameters.ball_diameter_m;
  scene::Scene scene;
  scene.offset_variable = "vertex_offset_m";
  for (std::uint32_t ball = 0; ball < world.balls(); ++ball) {
    add_feature(scene, scene::FeatureKind::body, fmt::format("ball {}", ball + 1));
    add_part(scene, scene::Shape::sphere, {diameter_m, diameter_m, diameter_m});
    scene.features.back().twin_of = 0;
  }
  const Vec2& half_m = world.bins().half_m();
  for (const physics::StaticMesh& mesh : simulated.meshes) {
    add_feature(scene, scene::FeatureKind::fixed, mesh.name);
    add_mesh(scene, *mesh.mesh, world.bins().vertex_count());
  }
  for (const physics::StaticConvex& convex : simulated.convexes) {
    add_feature(scene, scene::FeatureKind::fixed, convex.name);
    add_polyhedron(scene, *convex.polyhedron);
  }
  for (const physics::StaticPlane& plane : simulated.planes) {
    add_feature(scene, scene::FeatureKind::fixed, plane.name);
    add_part(scene, scene::Shape::ground, {4 * half_m.x(), 4 * half_m.y(), 0},
             {0, 0, plane.outside.offset_m});
  }
  for (std::uint32_t number = 0; number < world.balls(); ++number) {
    const Vec2& middle_m = world.middle_m(number);
    add_feature(scene, scene::FeatureKind::wanted, fmt::format("bin {}", number + 1));
    add_part(scene, scene::Shape::box, {parameters.bin_m, parameters.bin_m, 0},
             {middle_m.x(), middle_m.y(), 0});
  }
  scene.low_m = {-half_m.x(), -half_m.y(), 0};
  scene.high_m = {half_m.x(), half_m.y(), parameters.drop_height_m + diameter_m};
  return scene;
}

/// Maps numbers in the simulator's static geometry to scene features.
std::vector<std::int32_t> features_of(const physics::Scene& simulated, const scene::Scene& scene) {
  const physics::StaticGeometry geometry(simulated);
  std::vector<std::int32_t> features;
  for (physics::FeatureId index{}; index < geometry.feature_count(); ++index) {
    // Names look like "mesh 'bins'".
    const std::string_view name = geometry.name_of_feature(index);
    const auto open = name.find('\'');
    CHECK(open != std::string_view::npos && name.ends_with('\''));
    const auto found = scene.find(name.substr(open + 1, name.size() - open - 2));
    CHECK(found.has_value());
    features.push_back(static_cast<std::int32_t>(*found));
  }
  return features;
}

class SpellingReader final : public archive::StateReader {
 public:
  explicit SpellingReader(const Parameters& parameters)
      : world_(parameters), layout_(make_layout(world_)) {
    if (parameters.proposal.kernel == Kernel::thesis)
      layout_.warning = "biased kernel: thesis (A.2.2 as printed)";
    // A natural throw drops all balls. There are as many balls as designated bins, so all balls are
    // active in every solution.
    layout_.log_natural_throw = world_.balls() * math::log(0.5);
    const auto simulated = world_.scene(plain_state(world_));
    CHECK(simulated.has_value());
    scene_ = make_scene(world_, *simulated);
    fixed_ = features_of(*simulated, scene_);
  }

  const archive::WorldLayout& layout() const override { return layout_; }

  std::vector<double> variables(base::BytesView state) const override {
    // The layout's variables are in the order of the bytes.
    return values_of(decoded(world_, state));
  }

  /// For each designated bin, the ball that fills it.
  std::vector<double> likeness(base::BytesView state) const override {
    const std::vector<int> balls = world_.balls_of_bins(decoded(world_, state));
    return {balls.begin(), balls.end()};
  }

  double likeness_distance(std::span<const double> left,
                           std::span<const double> right) const override {
    double unlike = 0;
    for (std::size_t bin = 0; bin < left.size(); ++bin)
      unlike += left[bin] != right[bin] ? 1 : 0;
    return unlike / static_cast<double>(world_.balls());
  }

  archive::Motion play(base::BytesView bytes) const override {
    const State state = decoded(world_, bytes);
    const archive::PlaysOut ends = played_out(world_, world_.simulate_to_rest(state));
    if (ends != archive::PlaysOut::yes) return {.ends = ends};
    const Animation animation = world_.animate(state);
    std::vector<RecordedBody> bodies;
    for (const std::uint32_t ball : animation.balls)
      bodies.push_back({.feature = ball});
    return {.segments = recorded_segments(
                animation.recording, bodies,
                [&](std::uint32_t, std::uint32_t index) { return fixed_.at(index); })};
  }

  const scene::Scene& scene() const override { return scene_; }

  std::vector<double> prior_draw(std::uint64_t nth) const override {
    return archive::prior_values(layout_, values_of(sampling::nth_prior_draw(world_, nth)));
  }

  std::vector<double> log_priors_of_throws(std::size_t count) const override {
    return sampling::log_priors_of_throws(
        world_, count, [&](random::Stream& stream) { return world_.draw_throw(stream); });
  }

 private:
  Spelling world_;
  archive::WorldLayout layout_;
  scene::Scene scene_{};
  std::vector<std::int32_t> fixed_{};  ///< scene features by static-geometry index
};

}  // namespace

std::unique_ptr<archive::StateReader> make_state_reader(const Parameters& parameters) {
  return std::make_unique<SpellingReader>(parameters);
}

}  // namespace sleight::worlds::spelling
