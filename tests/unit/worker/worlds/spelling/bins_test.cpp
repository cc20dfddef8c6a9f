#include "worker/worlds/spelling/bins.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "common/random/distributions.h"

namespace sleight::worlds::spelling {
namespace {

TEST(Bins, MeasuresAreTheThesis) {
  // Goal: bins are 20 mm wide, and partitions are 2 mm thick and 12 mm high (thesis A.2.1). Method:
  // check the partitions' vertices in a box of three by two bins.
  const WorldParameters world;
  const Bins bins(world, 3, 2);
  EXPECT_NEAR(bins.half_m().x(), 0.032, 1e-12);
  EXPECT_NEAR(bins.half_m().y(), 0.021, 1e-12);
  // There are two inner crossings with four corners each, and six ends with two corners each.
  EXPECT_EQ(bins.vertex_count(), 2U * 4 + 6U * 2);
  std::set<long> xs;
  for (const Vec3& vertex_m : bins.vertices_m()) {
    EXPECT_EQ(vertex_m.z(), 0.012);
    xs.insert(std::lround(1e6 * vertex_m.x()));
  }
  EXPECT_EQ(xs, (std::set<long>{-33000, -12000, -10000, 10000, 12000, 33000}));
}

TEST(Bins, SurfacesOfAllSizesAreClosed) {
  // Goal: for any number of bins, the surface has no hole. Method: build surfaces of several sizes,
  // because their construction refuses holes. Also check that the Euler number is 2, as for a
  // sphere, and that the volume is right.
  const WorldParameters world;
  for (const auto& [columns, rows] :
       {std::pair{1U, 1U}, {1U, 2U}, {2U, 1U}, {2U, 2U}, {7U, 5U}, {40U, 12U}}) {
    const Bins bins(world, columns, rows);
    const std::vector<Vec3> none(bins.vertex_count(), Vec3::Zero());
    const auto mesh = bins.surface(none);
    ASSERT_TRUE(mesh);
    const auto vertices = static_cast<long>(mesh->vertices_m().size());
    const auto edges = static_cast<long>(mesh->edges().size());
    const auto faces = static_cast<long>(mesh->triangles().size());
    EXPECT_EQ(vertices - edges + faces, 2) << columns << " x " << rows;
    double volume_m3 = 0;
    for (const auto& t : mesh->triangles()) {
      const auto v = mesh->vertices_m();
      volume_m3 += math::dot(v[t[0]], math::cross(v[t[1]], v[t[2]])) / 6;
    }
    // Domes are pyramids. Partitions fill the box between the floors, and extend slightly into the
    // walls.
    const double n = static_cast<double>(columns) * rows;
    const double domes_m3 = n * 0.02 * 0.02 * 0.001 / 3;
    const double floor_m2 = 4 * bins.half_m().x() * bins.half_m().y();
    const double partitions_m3 = 0.012 * (floor_m2 - n * 0.02 * 0.02);
    const double ends = 2.0 * ((columns - 1) + (rows - 1));
    EXPECT_GT(volume_m3, floor_m2 * 0.01 + domes_m3 + partitions_m3) << columns << " x " << rows;
    EXPECT_LT(volume_m3, 4 * (bins.half_m().x() + 0.006) * (bins.half_m().y() + 0.006) * 0.01 +
                             domes_m3 + partitions_m3 + ends * 0.012 * 0.002 * 0.001);
  }
}

TEST(Bins, ThinPartitionsAreNoSlivers) {
  // Goal: the surface can be built for any valid grid and partition. Method: use grids of many
  // sizes with the thinnest valid partitions, which are a thousandth of a bin's width.
  WorldParameters world;
  world.partition_m = 0.001 * world.bin_m;
  world.vertex_sd_m = 0.1 * world.partition_m;
  for (const std::uint32_t columns : {1U, 2U, 3U, 6U, 7U, 15U, 30U, 39U, 40U}) {
    for (const std::uint32_t rows : {1U, 2U, 3U, 5U, 6U, 11U, 12U}) {
      const Bins bins(world, columns, rows);
      EXPECT_TRUE(bins.surface(std::vector<Vec3>(bins.vertex_count(), Vec3::Zero())))
          << columns << " x " << rows;
    }
  }
}

TEST(Bins, EveryPlaceIsInItsBin) {
  // Goal: bin_at() returns the bin with the nearest floor. For a place outside the box, bin_at()
  // returns no bin.
  const Bins bins(WorldParameters{}, 7, 5);
  random::Stream stream({.seed = 3, .purpose = random::Purpose::prior}, 0);
  for (int i = 0; i < 10'000; ++i) {
    const double x = random::Uniform{.low = -0.1, .high = 0.1}.draw(stream);
    const double y = random::Uniform{.low = -0.07, .high = 0.07}.draw(stream);
    const auto bin = bins.bin_at({x, y, 0.01});
    const bool inside = std::fabs(x) <= bins.half_m().x() && std::fabs(y) <= bins.half_m().y();
    ASSERT_EQ(bin.has_value(), inside);
    if (!inside) continue;
    const Vec3 middle_m = bins.floor_middle_m(*bin);
    EXPECT_LE(std::fabs(middle_m.x() - x), 0.011 + 1e-12);
    EXPECT_LE(std::fabs(middle_m.y() - y), 0.011 + 1e-12);
  }
}

TEST(Bins, OffsetsMoveTheirVertices) {
  // Goal: an offset moves only its own vertex of the surface, and extreme offsets are refused.
  // Method: move one vertex a little. Then move a second vertex to the place of a third one.
  const Bins bins(WorldParameters{}, 3, 3);
  std::vector<Vec3> offsets_m(bins.vertex_count(), Vec3::Zero());
  const auto before = bins.surface(offsets_m);
  offsets_m[5] = {1e-4, -2e-4, 3e-4};
  const auto after = bins.surface(offsets_m);
  ASSERT_TRUE(after);
  for (std::size_t v = 0; v < before->vertices_m().size(); ++v) {
    const Vec3 moved_m = after->vertices_m()[v] - before->vertices_m()[v];
    EXPECT_LT(math::norm(moved_m - (v == 5 ? offsets_m[5] : Vec3(0, 0, 0))), 1e-15) << v;
  }
  offsets_m[7] = bins.vertices_m()[6] - bins.vertices_m()[7];
  EXPECT_FALSE(bins.surface(offsets_m));
}

}  // namespace
}  // namespace sleight::worlds::spelling
