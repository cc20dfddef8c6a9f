#include "common/archive/structure.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "common/archive/format.h"

namespace sleight::archive {
namespace {

using Findings = std::vector<std::string>;
using Names = std::vector<std::string>;

struct Expected {
  std::string_view group;
  std::string_view name;
  ElementType type;
  Names dims;
};

/// Returns the datasets that every archive must have. Datasets of missing groups are skipped.
std::vector<Expected> expected_in_all() {
  using enum ElementType;
  const Names draws{"chain", "draw"};
  const Names kinds{"chain", "draw", "proposal_kind"};
  const Names replicas{"chain", "replica"};
  const Names animations{"animation"};
  return {
      {k_finds, "animation", i64, animations},
      {k_finds, "segment", i64, {"segment"}},
      {k_finds, "throw", i64, {"throw"}},
      {k_finds, "log_prior_of_throw", f64, {"throw"}},
      {k_finds, "start", i64, animations},
      {k_finds, "log_prior", f64, animations},
      {k_finds, "log_constraint", f64, animations},
      {k_finds, "segment_start", i64, animations},
      {k_finds, "segment_count", i64, animations},
      {k_root, k_request, text, {}},
      {k_posterior, "chain", i64, {"chain"}},
      {k_posterior, "draw", i64, {"draw"}},
      {k_sample_stats, "chain", i64, {"chain"}},
      {k_sample_stats, "draw", i64, {"draw"}},
      {k_sample_stats, "proposal_kind", text, {"proposal_kind"}},
      {k_sample_stats, "lp", f64, draws},
      {k_sample_stats, "log_prior", f64, draws},
      {k_sample_stats, "log_constraint", f64, draws},
      {k_sample_stats, "satisfied", boolean, draws},
      {k_sample_stats, "lineage", i64, draws},
      {k_sample_stats, "acceptance_rate", f64, draws},
      {k_sample_stats, "proposed", i32, kinds},
      {k_sample_stats, "accepted", i32, kinds},
      {k_replicas, "chain", i64, {"chain"}},
      {k_replicas, "replica", i64, {"replica"}},
      {k_replicas, "scan", i64, replicas},
      {k_replicas, "inverse_temperature", f64, replicas},
      {k_replicas, "log_prior", f64, replicas},
      {k_replicas, "log_constraint", f64, replicas},
      {k_animations, "animation", i64, animations},
      {k_animations, "segment", i64, {"segment"}},
      {k_animations, "chain", i64, animations},
      {k_animations, "draw", i64, animations},
      {k_animations, "lineage", i64, animations},
      {k_animations, "log_prior", f64, animations},
      {k_animations, "log_constraint", f64, animations},
      {k_animations, "segment_start", i64, animations},
      {k_animations, "segment_count", i64, animations},
  };
}

std::vector<Expected> expected_motions(std::string_view group) {
  using enum ElementType;
  const Names segments{"segment"};
  const Names vectors{"segment", "axis_xyz"};
  return {
      {group, "in_proportion", boolean, {"animation"}},
      {group, "body", i32, segments},
      {group, "start_s", f64, segments},
      {group, "mode", i32, segments},
      {group, "cause", i32, segments},
      {group, "partner", i32, segments},
      {group, "position_m", f64, vectors},
      {group, "velocity_mps", f64, vectors},
      {group, "acceleration_mps2", f64, vectors},
      {group, "axis_xyz", i64, {"axis_xyz"}},
      {group, "quaternion_wxyz", i64, {"quaternion_wxyz"}},
      {group, "orientation", f64, {"segment", "quaternion_wxyz"}},
      {group, "angular_velocity_radps", f64, vectors},
      {group, "angular_acceleration_radps2", f64, vectors},
  };
}

/// Returns the datasets for parts of the scene that belong to one animation. If an archive has one
/// of these datasets, it has all datasets of the same kind.
std::vector<Expected> expected_own_parts(std::string_view group) {
  using enum ElementType;
  return {
      {group, "part", i64, {"part"}},
      {group, "part_start", i64, {"animation"}},
      {group, "part_count", i64, {"animation"}},
      {group, "part_feature", i32, {"part"}},
      {group, "part_shape", i32, {"part"}},
      {group, "part_size_m", f64, {"part", "axis_xyz"}},
      {group, "part_position_m", f64, {"part", "axis_xyz"}},
      {group, "part_orientation", f64, {"part", "quaternion_wxyz"}},
  };
}

std::vector<Expected> expected_own_points(std::string_view group) {
  using enum ElementType;
  return {
      {group, "point", i64, {"point"}},
      {group, "point_start", i64, {"animation"}},
      {group, "point_count", i64, {"animation"}},
      {group, "point_i", i32, {"point"}},
      {group, "point_j", i32, {"point"}},
      {group, "point_height_m", f64, {"point"}},
      {group, "point_restitution", f64, {"point"}},
      {group, "point_friction", f64, {"point"}},
  };
}

std::vector<Expected> expected_scene_and_prior() {
  using enum ElementType;
  const Names draws{"chain", "draw"};
  return {
      {k_scene, "kind", text, {"kind"}},
      {k_scene, "shape", text, {"shape"}},
      {k_scene, "view_m", f64, {"end", "axis_xyz"}},
      {k_scene, "feature", i64, {"feature"}},
      {k_scene, "feature_name", text, {"feature"}},
      {k_scene, "feature_kind", i32, {"feature"}},
      {k_scene, "feature_twin_of", i32, {"feature"}},
      {k_scene, "feature_body", i32, {"feature"}},
      {k_scene, "part", i64, {"part"}},
      {k_scene, "part_feature", i32, {"part"}},
      {k_scene, "part_shape", i32, {"part"}},
      {k_scene, "part_size_m", f64, {"part", "axis_xyz"}},
      {k_scene, "part_position_m", f64, {"part", "axis_xyz"}},
      {k_scene, "part_orientation", f64, {"part", "quaternion_wxyz"}},
      {k_scene, "part_first_triangle", i32, {"part"}},
      {k_scene, "part_triangles", i32, {"part"}},
      {k_prior, "chain", i64, {"chain"}},
      {k_prior, "draw", i64, {"draw"}},
      {k_sample_stats_prior, "chain", i64, {"chain"}},
      {k_sample_stats_prior, "draw", i64, {"draw"}},
      {k_sample_stats_prior, "lp", f64, draws},
      {k_sample_stats_prior, "log_prior", f64, draws},
      {k_sample_stats_prior, "log_constraint", f64, draws},
      {k_sample_stats_prior, "satisfied", boolean, draws},
  };
}

std::vector<Expected> expected_meshes() {
  using enum ElementType;
  return {
      {k_scene, "vertex", i64, {"vertex"}},
      {k_scene, "vertex_m", f64, {"vertex", "axis_xyz"}},
      {k_scene, "vertex_offset", i32, {"vertex"}},
      {k_scene, "triangle", i64, {"triangle"}},
      {k_scene, "corner", i64, {"corner"}},
      {k_scene, "triangle_vertex", i32, {"triangle", "corner"}},
  };
}

bool has_dataset(const Source& source, std::string_view group, std::string_view dataset) {
  const Group* found = find_group(source, group);
  return found != nullptr && find_dataset(*found, dataset) != nullptr;
}

/// Returns the datasets expected for this archive's optional groups.
std::vector<Expected> expected_datasets(const Source& source) {
  std::vector<Expected> all = expected_in_all();
  const auto add = [&all](const std::vector<Expected>& more) {
    all.insert(all.end(), more.begin(), more.end());
  };
  add(expected_scene_and_prior());
  if (has_dataset(source, k_scene, "vertex")) add(expected_meshes());
  for (const std::string_view group : {k_animations, k_finds}) {
    add(expected_motions(group));
    if (has_dataset(source, group, "part")) add(expected_own_parts(group));
    if (has_dataset(source, group, "point")) add(expected_own_points(group));
  }
  return all;
}

Names dim_names(const DatasetSpec& spec) {
  Names names;
  for (const Dimension& dim : spec.dims)
    names.push_back(dim.name);
  return names;
}

std::string shown(ElementType type, const Names& dims) {
  return fmt::format("{} over ({})", name_of(type), fmt::join(dims, ", "));
}

void check_expected(const Source& source, const Expected& expected, Findings& findings) {
  const Group* group = find_group(source, expected.group);
  if (group == nullptr) return;  // reported once for the group
  const std::string path = path_of(expected.group, expected.name);
  const DatasetSpec* spec = find_dataset(*group, expected.name);
  if (spec == nullptr) {
    findings.push_back(fmt::format("{} is missing", path));
  } else if (spec->type != expected.type || dim_names(*spec) != expected.dims) {
    findings.push_back(fmt::format("{} is {}, expected {}", path,
                                   shown(spec->type, dim_names(*spec)),
                                   shown(expected.type, expected.dims)));
  }
}

template <class T>
void check_attribute(const Source& source, std::string_view group_name, std::string_view name,
                     Findings& findings) {
  const Group* group = find_group(source, group_name);
  if (group == nullptr) return;
  const Attribute* attribute = find_attribute(group->attributes, name);
  if (attribute == nullptr || !std::holds_alternative<T>(attribute->value)) {
    findings.push_back(
        fmt::format("{}: the attribute {} is missing or has the wrong type", group_name, name));
  }
}

template <class T>
void check_value(const Source& source, std::string_view name, const T& expected,
                 Findings& findings) {
  const Group* root = find_group(source, k_root);
  const Attribute* attribute = find_attribute(root->attributes, name);
  const T* value = attribute == nullptr ? nullptr : std::get_if<T>(&attribute->value);
  if (value == nullptr || *value != expected) {
    findings.push_back(fmt::format("/: the attribute {} is not {}", name, expected));
  }
}

/// Returns the leading dimensions allowed for a world's variable in a group.
std::vector<Names> leading_dims(std::string_view group) {
  if (group == k_posterior || group == k_sample_stats || group == k_sample_stats_prior)
    return {{"chain", "draw"}};
  // The mean and the standard deviation of a variable have no leading dimensions.
  if (group == k_prior) return {{"chain", "draw"}, {}};
  if (group == k_replicas) return {{"chain", "replica"}};
  if (group == k_tempering) return {{"chain"}};
  if (group == k_animations || group == k_finds) return {{"animation"}, {"segment"}};
  return {};
}

bool is_coordinate(const DatasetSpec& spec) {
  return spec.dims.size() == 1 && spec.dims[0].name == spec.name;
}

void check_coordinates(const Group& group, const DatasetSpec& spec, Findings& findings) {
  for (const Dimension& dim : spec.dims) {
    const DatasetSpec* coordinate = find_dataset(group, dim.name);
    if (coordinate == nullptr || !is_coordinate(*coordinate) ||
        coordinate->dims[0].size != dim.size) {
      findings.push_back(fmt::format("{}: dimension {} has no coordinate of the same size",
                                     path_of(group.name, spec.name), dim.name));
    }
  }
}

/// Any other dataset must be one of the world's variables or a variable's coordinate.
void check_other(const Group& group, const DatasetSpec& spec, Findings& findings) {
  const std::string path = path_of(group.name, spec.name);
  if (is_coordinate(spec)) {
    // The world's own dimensions may have names. /tempering and /scene have no such dimensions.
    const bool is_kinds = group.name == k_tempering && spec.name == "proposal_kind";
    const bool may_have_names = group.name != k_tempering && group.name != k_scene;
    const ElementType expected = is_kinds ? ElementType::text : ElementType::i64;
    if (spec.type != expected && !(may_have_names && spec.type == ElementType::text)) {
      findings.push_back(
          fmt::format("{} is {}, expected {}", path, name_of(spec.type), name_of(expected)));
    }
    return;
  }
  const Names dims = dim_names(spec);
  const std::vector<Names> allowed = leading_dims(group.name);
  const bool fits = std::ranges::any_of(allowed, [&dims](const Names& leading) {
    return dims.size() >= leading.size() &&
           std::equal(leading.begin(), leading.end(), dims.begin());
  });
  if (spec.type != ElementType::f64 || !fits) {
    findings.push_back(
        fmt::format("{} is {}, but a variable of a world can't have this type and these dimensions",
                    path, shown(spec.type, dims)));
  }
}

}  // namespace

std::vector<std::string> check_structure(const Source& source) {
  Findings findings;
  if (find_group(source, k_root) == nullptr) return {"the root group is missing"};
  check_value(source, "format", std::string(k_format_name), findings);
  check_value(source, "format_version", k_format_version, findings);
  check_value(source, "inference_library", std::string(k_inference_library), findings);
  check_attribute<std::string>(source, k_root, "world", findings);
  check_attribute<std::string>(source, k_root, k_inference_library_version, findings);
  check_attribute<std::string>(source, k_root, k_content_digest, findings);
  check_attribute<std::string>(source, k_root, k_results_version, findings);
  check_attribute<std::string>(source, k_root, k_run_id, findings);
  for (const std::string_view name : {k_posterior, k_sample_stats, k_replicas, k_animations,
                                      k_scene, k_prior, k_sample_stats_prior}) {
    if (find_group(source, name) == nullptr) {
      findings.push_back(fmt::format("the group {} is missing", name));
    }
  }
  check_attribute<std::int64_t>(source, k_posterior, "thin", findings);
  check_attribute<std::int64_t>(source, k_animations, "keep_max", findings);
  check_attribute<std::int64_t>(source, k_finds, "keep_max", findings);
  check_attribute<std::int64_t>(source, k_finds, k_found, findings);
  check_attribute<std::string>(source, k_finds, k_warning, findings);
  check_attribute<std::int64_t>(source, k_animations, "keep_per_lineage", findings);
  check_attribute<double>(source, k_animations, "min_distance", findings);

  const std::vector<Expected> all = expected_datasets(source);
  for (const Expected& expected : all)
    check_expected(source, expected, findings);
  for (const Group& group : source.groups()) {
    if (group.name != k_root && group.name != k_scene && leading_dims(group.name).empty()) {
      findings.push_back(fmt::format("the group {} is not part of the format", group.name));
    }
    for (const DatasetSpec& spec : group.datasets) {
      check_coordinates(group, spec, findings);
      const bool known = std::ranges::any_of(all, [&](const Expected& expected) {
        return expected.group == group.name && expected.name == spec.name;
      });
      if (!known) check_other(group, spec, findings);
    }
  }
  return findings;
}

}  // namespace sleight::archive
