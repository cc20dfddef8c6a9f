// Errors for points or parts that don't make a shape.
//
// Shapes come from requests and files, so a bad shape is an expected outcome. The makers then
// return an error instead of a shape. Thread safety: values.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

namespace sleight::physics {

struct ShapeError {
  enum class Kind : std::uint8_t {
    too_few_points,          ///< fewer than four
    too_many_points,         ///< more than k_hull_points_max
    not_finite,              ///< a coordinate of point `index` is NaN or infinite
    flat,                    ///< thinner than k_hull_flat of the extent; `measured` is that ratio
    degenerate,              ///< features as small as the tolerance make no consistent polyhedron
    not_spherical,           ///< declared spherical, but the moments differ; `measured`: relative
    not_axial,               ///< declared axial, but no two moments agree; `measured`: relative
    no_parts,                ///< a body without any part
    dimension_not_positive,  ///< a size, radius, density or count that must be positive
    too_many_features,       ///< a round piece has more than k_round_features_max
    no_axis,                 ///< a round piece's axis isn't of length 1, or its origin not finite
    sharp  ///< a round piece's edge: `measured` is its radius as a part of the piece's size
  };
  Kind kind{};
  std::size_t index = 0;
  double measured = 0;
  friend bool operator==(const ShapeError&, const ShapeError&) = default;
};

/// Returns whether a size, radius or density is positive and finite.
inline bool is_positive(double size) {
  return size > 0 && std::isfinite(size);
}
inline ShapeError not_positive(std::size_t index, double size) {
  return {.kind = ShapeError::Kind::dimension_not_positive, .index = index, .measured = size};
}

/// A sentence for people, without a full stop.
std::string describe(const ShapeError& error);

}  // namespace sleight::physics
