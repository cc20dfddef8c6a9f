// The fields of three tables: an animation's segments, its own parts of the scene, and its
// surface's control points. Private to common/archive.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <type_traits>

#include "common/motion/fields.h"
#include "common/scene/scene.h"

namespace sleight::archive {

template <class Value>
using Stored =
    std::conditional_t<std::same_as<motion::Element<Value>, double>, double, std::int32_t>;

inline constexpr std::tuple k_part_fields{
    motion::Field{"part_feature", &scene::Part::feature,
                  "feature of /scene that the part belongs to"},
    motion::Field{"part_shape", &scene::Part::shape,
                  "shape of the part, as an index along the dimension shape of /scene"},
    motion::Field{"part_size_m", &scene::Part::size_m, "sizes, as part_size_m of /scene", "m"},
    motion::Field{"part_position_m", &scene::Part::position_m,
                  "middle of the part, in the feature's frame", "m"},
    motion::Field{"part_orientation", &scene::Part::orientation,
                  "rotation from the part's frame to the feature's frame"}};

inline constexpr std::tuple k_point_fields{
    motion::Field{"point_i", &scene::ControlPoint::i,
                  "column of the control point; its x is point_i times the spacing"},
    motion::Field{"point_j", &scene::ControlPoint::j,
                  "row of the control point: y = point_j times the spacing"},
    motion::Field{"point_height_m", &scene::ControlPoint::height_m, "height of the control point",
                  "m"},
    motion::Field{"point_restitution", &scene::ControlPoint::restitution,
                  "coefficient of restitution at the control point"},
    motion::Field{"point_friction", &scene::ControlPoint::friction,
                  "coefficient of friction at the control point"}};

template <class Record, class... Values>
Record record_of(const std::tuple<motion::Field<Record, Values>...>& fields);
template <const auto& fields>
using RecordOf = decltype(record_of(fields));

}  // namespace sleight::archive

template <>
inline constexpr std::size_t sleight::motion::k_last<sleight::scene::Shape> =
    sleight::scene::k_shape_names.size() - 1;
