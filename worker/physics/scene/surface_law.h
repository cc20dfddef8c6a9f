// Restitution and friction for each pair of materials.
//
// Thread safety: values.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/base/ids.h"

namespace sleight::physics {

/// A material: an index into the table of contact laws.
using MaterialId = base::Id<struct MaterialTag, std::uint8_t>;

struct SurfaceLaw {
  double restitution = 1;       ///< 0 to 1
  double friction = 0;          ///< Coulomb's coefficient, >= 0
  double rolling_friction = 0;  ///< rolling deceleration of a sphere / normal acceleration, >= 0
};

/// Has a law for each pair of materials, in either order.
class ContactTable {
 public:
  ContactTable() : ContactTable(1) {}
  /// Makes a table with the same law for all pairs of materials.
  explicit ContactTable(std::size_t materials, const SurfaceLaw& law = {})
      : materials_(materials), laws_(materials * materials, law) {}

  void set(MaterialId a, MaterialId b, const SurfaceLaw& law) {
    laws_[index(a, b)] = law;
    laws_[index(b, a)] = law;
  }
  const SurfaceLaw& between(MaterialId a, MaterialId b) const { return laws_[index(a, b)]; }
  std::size_t materials() const { return materials_; }

 private:
  std::size_t index(MaterialId a, MaterialId b) const { return a.value * materials_ + b.value; }

  std::size_t materials_;
  std::vector<SurfaceLaw> laws_;
};

}  // namespace sleight::physics
