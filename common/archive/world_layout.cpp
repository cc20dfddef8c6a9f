#include <algorithm>
#include <cmath>

#include "common/archive/world_layout.h"
#include "common/base/check.h"

namespace sleight::archive {
namespace {

void append_vector(const math::Vec3& v, std::vector<double>& values) {
  values.insert(values.end(), {v.x(), v.y(), v.z()});
}

math::Vec3 vector_at(const double* values) {
  return {values[0], values[1], values[2]};
}

bool is_in_prior(const Variable& variable) {
  const bool is_all_normal =
      !variable.prior_sd.empty() &&
      std::ranges::none_of(variable.prior_sd, [](double sd) { return std::isnan(sd); });
  return !is_all_normal || variable.size() <= k_prior_elements_max;
}

}  // namespace

std::vector<Variable> prior_variables(const WorldLayout& layout) {
  std::vector<Variable> kept;
  for (const Variable& variable : layout.variables) {
    if (is_in_prior(variable)) kept.push_back(variable);
  }
  return kept;
}

std::vector<double> prior_values(const WorldLayout& layout, std::span<const double> values) {
  std::vector<double> kept;
  for (const Variable& variable : layout.variables) {
    const std::span<const double> own = values.first(variable.size());
    if (is_in_prior(variable)) kept.insert(kept.end(), own.begin(), own.end());
    values = values.subspan(variable.size());
  }
  return kept;
}

void Recording::append(const motion::Segment& segment) {
  const std::size_t before = values.size();
  values.insert(
      values.end(),
      {static_cast<double>(segment.body), segment.start_s, static_cast<double>(segment.mode),
       static_cast<double>(segment.cause), static_cast<double>(segment.partner)});
  append_vector(segment.position_m, values);
  append_vector(segment.velocity_mps, values);
  append_vector(segment.acceleration_mps2, values);
  const math::Quat& q = segment.orientation;
  values.insert(values.end(), {q.w(), q.x(), q.y(), q.z()});
  append_vector(segment.angular_velocity_radps, values);
  append_vector(segment.angular_acceleration_radps2, values);
  CHECK_EQ(values.size(), before + k_columns);
}

motion::Segment Recording::segment(std::size_t row) const {
  CHECK_LT(row, rows());
  const double* at = &values[row * k_columns];
  return {.body = static_cast<std::uint32_t>(at[0]),
          .start_s = at[1],
          .mode = static_cast<motion::Mode>(at[2]),
          .cause = static_cast<motion::Cause>(at[3]),
          .partner = static_cast<std::int32_t>(at[4]),
          .position_m = vector_at(at + 5),
          .velocity_mps = vector_at(at + 8),
          .acceleration_mps2 = vector_at(at + 11),
          .orientation = {at[14], at[15], at[16], at[17]},
          .angular_velocity_radps = vector_at(at + 18),
          .angular_acceleration_radps2 = vector_at(at + 21)};
}

}  // namespace sleight::archive
