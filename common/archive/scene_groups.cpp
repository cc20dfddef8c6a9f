#include "common/archive/scene_groups.h"

#include <string>
#include <vector>

#include "common/archive/format.h"
#include "common/archive/specs.h"
#include "common/base/check.h"

namespace sleight::archive {
namespace {

Column<std::int32_t> small(Sink& sink, const char* name, const Dims& dims, const char* long_name) {
  return {sink, k_scene, spec_of(name, ElementType::i32, dims, long_name)};
}

Column<double> metres(Sink& sink, const char* name, const Dims& dims, const char* long_name) {
  return {sink, k_scene, spec_of(name, ElementType::f64, dims, long_name, "m")};
}

template <std::size_t n>
void write_names(Sink& sink, const char* dim, const std::array<std::string_view, n>& names,
                 const char* long_name) {
  const std::vector<std::string> words(names.begin(), names.end());
  write_words(sink, k_scene, dim, {{dim, n}}, long_name, words);
}

void write_features(const scene::Scene& scene, Sink& sink) {
  const Dims feature{{"feature", scene.features.size()}};
  write_coordinate(sink, k_scene, feature[0], "scene feature; bodies come first");
  std::vector<std::string> names;
  for (const scene::Feature& one : scene.features)
    names.push_back(one.name);
  write_words(sink, k_scene, "feature_name", feature, "name of the feature", names);
  auto kind = small(sink, "feature_kind", feature,
                    "kind of the feature, as an index along the dimension kind");
  auto twin = small(sink, "feature_twin_of", feature,
                    "first body that is interchangeable with this body; the body itself if there "
                    "is no such body");
  auto body =
      small(sink, "feature_body", feature, "body to which the goal applies; -1: any body, or none");
  for (const scene::Feature& one : scene.features) {
    kind.push(static_cast<std::int32_t>(one.kind));
    twin.push(small_of(one.twin_of));
    body.push(one.body);
  }
  for (auto* column : {&kind, &twin, &body})
    column->flush();
}

void write_parts(const scene::Scene& scene, Sink& sink) {
  const Dims part{{"part", scene.parts.size()}};
  const Dims vectors{part[0], k_axis};
  write_coordinate(sink, k_scene, part[0], "part of a feature");
  auto feature = small(sink, "part_feature", part, "feature that the part belongs to");
  auto shape =
      small(sink, "part_shape", part, "shape of the part, as an index along the dimension shape");
  auto size =
      metres(sink, "part_size_m", vectors,
             "lengths of the sides; sphere and disc: x is the diameter; surface: x and y are "
             "the sides and z is the spacing of the control points");
  auto position =
      metres(sink, "part_position_m", vectors,
             "middle of the part, in the body's frame; in the scene's frame if the part is fixed");
  Column<double> orientation(
      sink, k_scene,
      spec_of("part_orientation", ElementType::f64, {part[0], k_quaternion},
              "rotation from the part's frame to the frame of part_position_m", "1"));
  auto first =
      small(sink, "part_first_triangle", part, "first triangle of a mesh, an index along triangle");
  auto triangles = small(sink, "part_triangles", part, "number of triangles of a mesh");
  for (const scene::Part& one : scene.parts) {
    feature.push(small_of(one.feature));
    shape.push(static_cast<std::int32_t>(one.shape));
    push_vector(size, one.size_m);
    push_vector(position, one.position_m);
    const math::Quat& q = one.orientation;
    for (const double value : {q.w(), q.x(), q.y(), q.z()})
      orientation.push(value);
    first.push(small_of(one.first_triangle));
    triangles.push(small_of(one.triangles));
  }
  for (auto* column : {&feature, &shape, &first, &triangles})
    column->flush();
  for (auto* column : {&size, &position, &orientation})
    column->flush();
}

void write_meshes(const scene::Scene& scene, Sink& sink) {
  if (scene.triangles.empty()) return;
  const Dims vertex{{"vertex", scene.vertices.size()}};
  write_coordinate(sink, k_scene, vertex[0], "vertex of a mesh");
  auto place = metres(sink, "vertex_m", {vertex[0], k_axis}, "vertex, in the frame of its part");
  auto offset = small(sink, "vertex_offset", vertex,
                      "row of the variable named by offset_variable whose value is added to the "
                      "vertex; -1: no value is added");
  for (const scene::Vertex& one : scene.vertices) {
    push_vector(place, one.place_m);
    offset.push(one.offset);
  }
  place.flush();
  offset.flush();
  const Dims triangle{{"triangle", scene.triangles.size()}, {"corner", 3}};
  write_coordinate(sink, k_scene, triangle[0], "triangle of a mesh");
  write_coordinate(sink, k_scene, triangle[1],
                   "corner of a triangle, counter-clockwise when seen from outside");
  auto corner = small(sink, "triangle_vertex", triangle,
                      "corner of the triangle, as an index along the dimension vertex");
  for (const auto& one : scene.triangles) {
    for (const std::uint32_t index : one)
      corner.push(small_of(index));
  }
  corner.flush();
}

void write_normal_priors(Sink& sink, const std::vector<Variable>& variables) {
  for (const Variable& variable : variables) {
    if (variable.prior_sd.empty()) continue;
    const auto write = [&](const char* suffix, const std::vector<double>& values,
                           const char* long_name) {
      CHECK_EQ(values.size(), variable.size());
      Column<double> column(sink, k_prior,
                            spec_of(variable.name + suffix, ElementType::f64, variable.dims,
                                    long_name, variable.unit));
      for (const double value : values)
        column.push(value);
      column.flush();
    };
    write("_prior_mean", variable.prior_mean,
          "mean under the prior; NaN if not normally distributed");
    write("_prior_sd", variable.prior_sd,
          "standard deviation under the prior; NaN if the distribution is not normal, 0 if the "
          "value is fixed");
  }
}

}  // namespace

void write_scene(const scene::Scene& scene, Sink& sink) {
  CHECK_EQ(scene::fault_of(scene), "");
  sink.create_group(k_scene);
  if (!scene.offset_variable.empty())
    sink.set_attribute(k_scene, {"offset_variable", scene.offset_variable});
  for (const Dimension& dim : {k_axis, k_quaternion})
    write_coordinate(sink, k_scene, dim, "index of the " + dim.name);
  write_names(sink, "kind", scene::k_kind_names, "kind of feature");
  write_names(sink, "shape", scene::k_shape_names, "shape of a part");
  const Dimension end{"end", 2};
  write_coordinate(sink, k_scene, end, "low and high end");
  auto view = metres(sink, "view_m", {end, k_axis}, "box that encloses the bodies' motion");
  push_vector(view, scene.low_m);
  push_vector(view, scene.high_m);
  view.flush();
  write_features(scene, sink);
  write_parts(scene, sink);
  write_meshes(scene, sink);
}

void write_prior(const RunView& view, const StateReader& reader, Sink& sink) {
  const WorldLayout& layout = reader.layout();
  const Dims leading{{"chain", 1}, {"draw", view.prior_draws()}};
  sink.create_group(k_prior);
  write_coordinate(sink, k_prior, leading[0], "the only chain");
  write_coordinate(sink, k_prior, leading[1], "draw from the prior");
  Dims written = leading;
  write_own_coordinates(sink, k_prior, layout.variables, written);
  write_normal_priors(sink, layout.variables);
  VariableColumns states(sink, k_prior, leading, prior_variables(layout));
  for (std::uint64_t nth = 0; nth < view.prior_draws(); ++nth)
    states.push(reader.prior_draw(nth));
  states.flush();

  sink.create_group(k_sample_stats_prior);
  write_coordinate(sink, k_sample_stats_prior, leading[0], "the only chain");
  write_coordinate(sink, k_sample_stats_prior, leading[1], "draw from the prior");
  written = leading;
  write_own_coordinates(sink, k_sample_stats_prior, layout.outcomes, written);
  Column<double> lp(sink, k_sample_stats_prior,
                    spec_of("lp", ElementType::f64, leading, "log_prior + log_constraint"));
  DensityColumns densities(sink, k_sample_stats_prior, leading);
  Column<std::int8_t> satisfied(sink, k_sample_stats_prior,
                                spec_of("satisfied", ElementType::boolean, leading,
                                        "whether the outcome satisfies the constraint"));
  VariableColumns outcomes(sink, k_sample_stats_prior, leading, layout.outcomes);
  view.for_each_prior_draw([&](std::uint64_t, const plan::ScanRecord& draw) {
    lp.push(draw.log_prior + draw.log_constraint);
    densities.push(draw.log_prior, draw.log_constraint);
    satisfied.push(draw.satisfied ? 1 : 0);
    outcomes.push(draw.outcome);
  });
  lp.flush();
  densities.flush();
  satisfied.flush();
  outcomes.flush();
}

}  // namespace sleight::archive
