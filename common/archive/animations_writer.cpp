#include "common/archive/animations_writer.h"

#include <algorithm>
#include <concepts>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "common/archive/specs.h"
#include "common/archive/tables.h"
#include "common/base/check.h"

namespace sleight::archive {
namespace {

using Integers = Column<std::int64_t>;

struct Maker {
  Sink& sink;
  std::string_view group;

  Integers integers(const char* name, const Dims& dims, const char* long_name) const {
    return {sink, group, spec_of(name, ElementType::i64, dims, long_name)};
  }
};

/// Two columns for a dimension: each animation's first row and number of rows.
class Rows {
 public:
  Rows(const Maker& maker, const char* dim, const char* counted)
      : start_(maker.integers((std::string(dim) + "_start").c_str(), {{"animation", k_growing}},
                              "index of the animation's first row along this dimension")),
        count_(maker.integers((std::string(dim) + "_count").c_str(), {{"animation", k_growing}},
                              "number of the animation's rows along this dimension")),
        row_(maker.integers(dim, {{dim, k_growing}}, counted)) {}

  void push(std::size_t rows) {
    start_.push(next_);
    count_.push(signed_of(rows));
    for (std::size_t i = 0; i < rows; ++i)
      row_.push(next_++);
  }
  void flush() {
    start_.flush();
    count_.flush();
    row_.flush();
  }

 private:
  Integers start_;
  Integers count_;
  Integers row_;
  std::int64_t next_ = 0;
};

template <class Record, class Value>
class FieldColumn {
 public:
  FieldColumn(const Maker& maker, const char* dim, const motion::Field<Record, Value>& field)
      : member_(field.member),
        column_(maker.sink, maker.group,
                spec_of(field.name, k_type, dims(dim), field.meaning, field.unit)) {}

  void push(const Record& record) {
    for (const auto element : motion::elements_of(record.*member_)) {
      if constexpr (k_type == ElementType::i32) CHECK(std::in_range<std::int32_t>(element));
      column_.push(static_cast<Stored<Value>>(element));
    }
  }
  void flush_if(ElementType type) {
    if (type == k_type) column_.flush();
  }

 private:
  static constexpr ElementType k_type =
      std::same_as<Stored<Value>, double> ? ElementType::f64 : ElementType::i32;

  static Dims dims(const char* dim) {
    Dims dims{{dim, k_growing}};
    if (motion::k_width<Value> == k_axis.size) dims.push_back(k_axis);
    if (motion::k_width<Value> == k_quaternion.size) dims.push_back(k_quaternion);
    return dims;
  }

  Value Record::*member_;
  Column<Stored<Value>> column_;
};

/// Returns columns in the order of the fields. Brace initialisation guarantees this order.
template <const auto& fields>
auto columns_of(const Maker& maker, const char* dim) {
  return std::apply(
      [&](const auto&... each) { return std::tuple{FieldColumn(maker, dim, each)...}; }, fields);
}

template <const auto& fields>
class AnimationTable {
 public:
  AnimationTable(const Maker& maker, const char* dim, const char* counted)
      : rows_(maker, dim, counted), columns_(columns_of<fields>(maker, dim)) {}

  void push(std::span<const RecordOf<fields>> records) {
    rows_.push(records.size());
    for (const auto& record : records)
      std::apply([&](auto&... columns) { (columns.push(record), ...); }, columns_);
  }
  void flush() {
    rows_.flush();
    // The order of flushing determines where datasets are in the file. With this order, files have
    // the same bytes as those of earlier versions.
    for (const ElementType type : {ElementType::i32, ElementType::f64})
      std::apply([&](auto&... columns) { (columns.flush_if(type), ...); }, columns_);
  }

 private:
  Rows rows_;
  decltype(columns_of<fields>(std::declval<const Maker&>(), "")) columns_;
};

/// Write the coordinates of two dimensions: the axes of positions and the components of rotations.
/// Other datasets of the group need these coordinates.
struct Axes {
  explicit Axes(const Maker& maker) {
    for (const Dimension& dim : {k_axis, k_quaternion})
      write_coordinate(maker.sink, maker.group, dim, "index of the " + dim.name);
  }
};

}  // namespace

struct AnimationsWriter::Columns {
  Columns(const StateReader& state_reader, const Maker& maker, const char* counted,
          std::span<const Address> address_columns, bool is_in_proportion)
      : reader(state_reader),
        axes(maker),
        animation(maker.integers("animation", k_animation, counted)),
        addresses(columns_of(maker, address_columns)),
        in_proportion(maker.sink, maker.group,
                      spec_of("in_proportion", ElementType::boolean, k_animation,
                              "true: a draw in the model's proportions; false: a find")),
        proportion(is_in_proportion ? 1 : 0),
        densities(maker.sink, maker.group, k_animation),
        segments(maker, "segment", "segments of motions, animation by animation") {
    const WorldLayout& layout = reader.layout();
    Dims written{k_axis, k_quaternion};
    write_own_coordinates(maker.sink, maker.group, layout.variables, written);
    write_own_coordinates(maker.sink, maker.group, layout.outcomes, written);
    outcomes.emplace(maker.sink, maker.group, k_animation, layout.outcomes);
    states.emplace(maker.sink, maker.group, k_animation, layout.variables);
    if (reader.scene().has_own_parts)
      parts.emplace(maker, "part", "part that belongs to one animation");
    if (reader.scene().has_own_points)
      points.emplace(maker, "point",
                     "control point of the surface, near a place where a body touches the surface");
  }

  static std::vector<Integers> columns_of(const Maker& maker, std::span<const Address> addresses) {
    std::vector<Integers> columns;
    for (const Address& address : addresses)
      columns.push_back(maker.integers(address.name, k_animation, address.meaning));
    return columns;
  }

  inline static const Dims k_animation{{"animation", k_growing}};
  const StateReader& reader;
  Axes axes;
  std::int64_t animations = 0;
  Integers animation;
  std::vector<Integers> addresses;
  Column<std::int8_t> in_proportion;
  std::int8_t proportion;
  DensityColumns densities;
  AnimationTable<motion::k_fields> segments;
  std::optional<VariableColumns> outcomes{}, states{};
  std::optional<AnimationTable<k_part_fields>> parts{};
  std::optional<AnimationTable<k_point_fields>> points{};
};

AnimationsWriter::AnimationsWriter(const StateReader& reader, std::string_view group,
                                   const char* counted, std::span<const Address> addresses,
                                   bool in_proportion, Sink& sink)
    : columns_(std::make_unique<Columns>(reader, Maker{.sink = sink, .group = group}, counted,
                                         addresses, in_proportion)) {}

AnimationsWriter::~AnimationsWriter() = default;

void AnimationsWriter::push(std::initializer_list<std::int64_t> addresses,
                            const plan::ScanRecord& record) {
  Columns& columns = *columns_;
  CHECK_EQ(addresses.size(), columns.addresses.size());
  columns.animation.push(columns.animations++);
  columns.in_proportion.push(columns.proportion);
  for (std::size_t i = 0; i < addresses.size(); ++i)
    columns.addresses[i].push(addresses.begin()[i]);
  columns.densities.push(record.log_prior, record.log_constraint);
  columns.outcomes->push(record.outcome);
  columns.states->push(columns.reader.variables(record.state));
  const std::vector<motion::Segment> segments = columns.reader.play(record.state).segments;
  columns.segments.push(segments);
  if (!columns.parts && !columns.points) return;
  const scene::Variation own = columns.reader.variation(record.state, segments);
  if (columns.parts) {
    CHECK(std::ranges::all_of(own.parts, [](const auto& part) { return part.triangles == 0; }));
    columns.parts->push(own.parts);
  }
  if (columns.points) columns.points->push(own.points);
}

void AnimationsWriter::flush() {
  Columns& columns = *columns_;
  columns.animation.flush();
  columns.in_proportion.flush();
  for (Integers& address : columns.addresses)
    address.flush();
  columns.densities.flush();
  columns.segments.flush();
  columns.outcomes->flush();
  columns.states->flush();
  if (columns.parts) columns.parts->flush();
  if (columns.points) columns.points->flush();
}

}  // namespace sleight::archive
