#include "common/archive/kept_motions.h"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "common/archive/format.h"
#include "common/archive/structure.h"
#include "common/archive/tables.h"
#include "common/base/check.h"

namespace sleight::archive {
namespace {

using math::Quat;
using math::Vec3;
using Small = std::vector<std::int32_t>;
using Numbers = std::vector<double>;

Vec3 vector_at(const Numbers& values, std::size_t row) {
  return {values[3 * row], values[3 * row + 1], values[3 * row + 2]};
}

Quat quaternion_at(const Numbers& values, std::size_t row) {
  const double* q = &values[4 * row];
  return {q[0], q[1], q[2], q[3]};
}

/// Returns nothing if the number is not in the enumeration.
template <class Enum>
std::optional<Enum> one_of(std::int32_t number, std::size_t count) {
  if (number < 0 || std::cmp_greater_equal(number, count)) return std::nullopt;
  return static_cast<Enum>(number);
}

/// Reads the tables of /scene, whose structure is valid.
class SceneReader {
 public:
  explicit SceneReader(const Source& source)
      : source_(source), group_(*find_group(source, k_scene)) {}

  std::string read() {
    for (const char* dim : {"feature", "part", "vertex", "triangle"}) {
      if (rows(dim) > k_scene_rows_max)
        return fmt::format("the scene has more than {} entries along {}", k_scene_rows_max, dim);
    }
    // The archive's names of kinds and shapes must equal this program's names.
    if (!has_words("kind", scene::k_kind_names) || !has_words("shape", scene::k_shape_names))
      return "the scene has kinds or shapes that are not in the archive format";
    const bool is_read = read_features() && read_parts() && read_meshes();
    if (!is_read) return "the scene has indices out of range";
    const auto view = numbers("view_m", 6);
    scene.low_m = vector_at(view, 0);
    scene.high_m = vector_at(view, 1);
    if (const Attribute* offsets = find_attribute(group_.attributes, "offset_variable")) {
      const auto* name = std::get_if<std::string>(&offsets->value);
      if (name == nullptr) return "the scene's attribute offset_variable is not a string";
      scene.offset_variable = *name;
    }
    for (const std::string_view group : {k_animations, k_finds}) {
      const Group* found = find_group(source_, group);
      if (found == nullptr) continue;
      scene.has_own_parts = scene.has_own_parts || find_dataset(*found, "part") != nullptr;
      scene.has_own_points = scene.has_own_points || find_dataset(*found, "point") != nullptr;
    }
    const std::string fault = scene::fault_of(scene);
    return fault.empty() ? std::string() : "is invalid: " + fault;
  }

  scene::Scene scene{};

 private:
  std::uint64_t rows(const char* dim) const {
    const DatasetSpec* coordinate = find_dataset(group_, dim);
    return coordinate == nullptr ? 0 : coordinate->dims[0].size;
  }
  template <class Element>
  std::vector<Element> whole(const char* name, std::uint64_t count) const {
    return std::get<std::vector<Element>>(source_.read(k_scene, name, 0, count));
  }
  Small small(const char* name, const char* dim) const {
    return whole<std::int32_t>(name, rows(dim));
  }
  Numbers numbers(const char* name, std::uint64_t count) const {
    return whole<double>(name, count);
  }
  template <std::size_t n>
  bool has_words(const char* dim, const std::array<std::string_view, n>& expected) const {
    if (rows(dim) != n) return false;
    return std::ranges::equal(whole<std::string>(dim, n), expected);
  }

  bool read_features() {
    const std::uint64_t count = rows("feature");
    const auto names = whole<std::string>("feature_name", count);
    const Small kinds = small("feature_kind", "feature");
    const Small twins = small("feature_twin_of", "feature");
    const Small bodies = small("feature_body", "feature");
    for (std::size_t i = 0; i < count; ++i) {
      const auto kind = one_of<scene::FeatureKind>(kinds[i], scene::k_kind_names.size());
      if (!kind || twins[i] < 0) return false;
      scene.features.push_back({.name = names[i],
                                .kind = *kind,
                                .twin_of = static_cast<std::uint32_t>(twins[i]),
                                .body = bodies[i]});
    }
    return true;
  }

  bool read_parts() {
    const std::uint64_t count = rows("part");
    const Small features = small("part_feature", "part");
    const Small shapes = small("part_shape", "part");
    const Small first = small("part_first_triangle", "part");
    const Small triangles = small("part_triangles", "part");
    const Numbers sizes = numbers("part_size_m", 3 * count);
    const Numbers positions = numbers("part_position_m", 3 * count);
    const Numbers turns = numbers("part_orientation", 4 * count);
    for (std::size_t i = 0; i < count; ++i) {
      const auto shape = one_of<scene::Shape>(shapes[i], scene::k_shape_names.size());
      if (!shape || features[i] < 0 || first[i] < 0 || triangles[i] < 0) return false;
      scene.parts.push_back({.feature = static_cast<std::uint32_t>(features[i]),
                             .shape = *shape,
                             .size_m = vector_at(sizes, i),
                             .position_m = vector_at(positions, i),
                             .orientation = quaternion_at(turns, i),
                             .first_triangle = static_cast<std::uint32_t>(first[i]),
                             .triangles = static_cast<std::uint32_t>(triangles[i])});
    }
    return true;
  }

  bool read_meshes() {
    const std::uint64_t vertices = rows("vertex");
    if (vertices == 0) return true;
    const Numbers places = numbers("vertex_m", 3 * vertices);
    const Small offsets = small("vertex_offset", "vertex");
    for (std::size_t i = 0; i < vertices; ++i)
      scene.vertices.push_back({.place_m = vector_at(places, i), .offset = offsets[i]});
    const std::uint64_t triangles = rows("triangle");
    const auto corners = whole<std::int32_t>("triangle_vertex", 3 * triangles);
    for (std::size_t i = 0; i < triangles; ++i) {
      std::array<std::uint32_t, 3> triangle{};
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const std::int32_t index = corners[3 * i + corner];
        if (index < 0) return false;
        triangle[corner] = static_cast<std::uint32_t>(index);
      }
      scene.triangles.push_back(triangle);
    }
    return true;
  }

  const Source& source_;
  const Group& group_;
};

/// Returns whether points are sorted by row, then by column.
bool are_in_order(std::span<const scene::ControlPoint> points) {
  return std::ranges::is_sorted(points, [](const auto& a, const auto& b) {
    return std::pair(a.j, a.i) < std::pair(b.j, b.i);
  });
}

constexpr std::int32_t k_index_max = 1'000'000'000;

}  // namespace

base::Result<scene::Scene, std::string> scene_of(const Source& source) {
  if (const auto findings = check_structure(source); !findings.empty()) return findings.front();
  SceneReader reader(source);
  if (std::string fault = reader.read(); !fault.empty()) return fault;
  return std::move(reader.scene);
}

KeptMotions::KeptMotions(const Source& source, std::string_view group)
    : source_(source), group_(group) {
  const Group* found = find_group(source, group);
  CHECK(found != nullptr);
  count_ = find_dataset(*found, "animation")->dims[0].size;
}

base::Result<KeptMotions::Rows, std::string> KeptMotions::rows(std::uint64_t nth,
                                                               const std::string& dim,
                                                               std::uint64_t most) const {
  const auto start =
      std::get<std::vector<std::int64_t>>(source_.read(group_, dim + "_start", nth, 1)).at(0);
  const auto count =
      std::get<std::vector<std::int64_t>>(source_.read(group_, dim + "_count", nth, 1)).at(0);
  const std::uint64_t total = find_dataset(*find_group(source_, group_), dim)->dims[0].size;
  const bool is_inside =
      start >= 0 && count >= 0 && std::cmp_less_equal(start, total) &&
      static_cast<std::uint64_t>(count) <= total - static_cast<std::uint64_t>(start);
  if (!is_inside) return fmt::format("rows along {} are missing", dim);
  if (std::cmp_greater(count, most))
    return fmt::format("the animation has more than {} rows along {}", most, dim);
  return Rows{.first = static_cast<std::uint64_t>(start),
              .count = static_cast<std::uint64_t>(count)};
}

template <class Element>
std::vector<Element> KeptMotions::column(std::string_view name, const Rows& rows,
                                         std::uint64_t width) const {
  return std::get<std::vector<Element>>(
      source_.read(group_, name, rows.first * width, rows.count * width));
}

template <const auto& fields>
auto KeptMotions::records(const Rows& rows) const {
  std::vector<RecordOf<fields>> records(rows.count);
  motion::for_each_field(fields,
                         [&]<class Record, class Value>(const motion::Field<Record, Value>& field) {
                           constexpr std::size_t width = motion::k_width<Value>;
                           const auto numbers = column<Stored<Value>>(field.name, rows, width);
                           for (std::size_t i = 0; i < records.size(); ++i) {
                             const auto value = motion::value_of<Value>(&numbers[width * i]);
                             if (value)
                               records[i].*field.member = *value;
                             else
                               records.resize(i);
                           }
                         });
  return records;
}

base::Result<motion::Animation, std::string> KeptMotions::animation(
    std::uint64_t nth, const scene::Scene& scene) const {
  const auto found = rows(nth, "segment", k_segments_max);
  if (!found) return found.error();
  const Rows& range = found.value();
  const auto segments = records<motion::k_fields>(range);
  for (std::size_t i = 0; i < range.count; ++i) {
    if (i == segments.size()) return fmt::format("invalid segment {}", i);
    const motion::Segment& segment = segments[i];
    const bool has_partner = segment.partner != motion::k_no_partner;
    const bool is_partner = segment.partner >= 0 &&
                            std::cmp_less(segment.partner, scene.features.size()) &&
                            std::cmp_not_equal(segment.partner, segment.body);
    if ((has_partner && !is_partner) || has_partner != (segment.cause == motion::Cause::hit))
      return fmt::format("invalid segment {}", i);
  }
  return motion::Animation::of(segments, scene.bodies());
}

base::Result<scene::Variation, std::string> KeptMotions::variation(
    std::uint64_t nth, const scene::Scene& scene) const {
  scene::Variation own;
  const Group& group = *find_group(source_, group_);
  if (find_dataset(group, "part") != nullptr) {
    const auto found = rows(nth, "part", k_own_rows_max);
    if (!found) return found.error();
    const Rows& range = found.value();
    own.parts = records<k_part_fields>(range);
    if (own.parts.size() < range.count) return fmt::format("invalid part {}", own.parts.size());
    if (const std::string fault = scene::fault_of_parts(own.parts, scene); !fault.empty())
      return "invalid parts: " + fault;
  }
  if (find_dataset(group, "point") != nullptr) {
    const auto found = rows(nth, "point", k_own_rows_max);
    if (!found) return found.error();
    const Rows& range = found.value();
    own.points = records<k_point_fields>(range);
    for (std::size_t row = 0; row < own.points.size(); ++row) {
      const scene::ControlPoint& point = own.points[row];
      const bool is_sane = std::abs(point.height_m) <= motion::k_number_max &&
                           point.restitution >= 0 && point.restitution <= 1 &&
                           point.friction >= 0 && point.i > -k_index_max && point.i < k_index_max &&
                           point.j > -k_index_max && point.j < k_index_max;
      if (!is_sane) return fmt::format("invalid control point {}", row);
    }
    if (!are_in_order(own.points)) return std::string("the control points are out of order");
  }
  return own;
}

std::vector<Vec3> KeptMotions::offsets_m(std::uint64_t nth, const scene::Scene& scene) const {
  if (scene.offset_variable.empty()) return {};
  const DatasetSpec* spec = find_dataset(*find_group(source_, group_), scene.offset_variable);
  const bool is_offsets = spec != nullptr && spec->type == ElementType::f64 &&
                          spec->dims.size() == 3 && spec->dims[0].name == "animation" &&
                          spec->dims[2].size == 3 && spec->dims[1].size <= k_scene_rows_max;
  if (!is_offsets) return {};
  const std::uint64_t rows = spec->dims[1].size;
  const Numbers values =
      column<double>(scene.offset_variable, {.first = nth, .count = 1}, 3 * rows);
  std::vector<Vec3> offsets;
  for (std::size_t row = 0; row < rows; ++row) {
    const Vec3 offset = vector_at(values, row);
    // An invalid offset draws nothing.
    offsets.push_back(offset.allFinite() ? offset : Vec3{0, 0, 0});
  }
  return offsets;
}

bool KeptMotions::in_proportion(std::uint64_t nth) const {
  return std::get<std::vector<std::int8_t>>(source_.read(group_, "in_proportion", nth, 1)).at(0) ==
         1;
}

}  // namespace sleight::archive
