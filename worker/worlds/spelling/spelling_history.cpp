#include "worker/worlds/spelling/spelling_history.h"

#include <iterator>
#include <set>

#include "common/base/check.h"

namespace sleight::worlds::spelling {
namespace {

/// Margin around moved vertices. This margin is greater than the touch distance and rounding.
constexpr float k_margin_m = 1e-5F;

}  // namespace

bool starts_alike(const State& state, const State& candidate, std::size_t ball) {
  return candidate.active[ball] != 0 && state.active[ball] != 0 &&
         candidate.drops_m[ball] == state.drops_m[ball];
}

bool resembles(const State& candidate, const State& state) {
  std::size_t moved = 0;
  for (std::size_t vertex = 0; vertex < state.offsets_m.size(); ++vertex)
    moved += candidate.offsets_m[vertex] != state.offsets_m[vertex] ? 1U : 0U;
  if (2 * moved > state.offsets_m.size()) return false;
  for (std::size_t ball = 0; ball < state.active.size(); ++ball) {
    if (starts_alike(state, candidate, ball)) return true;
  }
  return false;
}

physics::MarbleHistories histories_that_hold(const SpellingHistory& history, const State& state,
                                             const State& candidate) {
  CHECK_EQ(history.histories.size(), candidate.active.size());
  physics::MarbleHistories histories = history.histories;
  for (std::size_t ball = 0; ball < histories.size(); ++ball) {
    if (!starts_alike(state, candidate, ball)) histories[ball] = nullptr;
  }
  return histories;
}

Influence::Influence(const Bins& bins, const physics::StaticGeometry& statics) {
  const auto mesh = bins.unmoved_surface();
  vertices_m_.assign(mesh->vertices_m().begin(), mesh->vertices_m().end());
  std::set<std::uint32_t> edges;
  for (std::uint32_t vertex = 0; vertex < bins.vertex_count(); ++vertex) {
    Vertex& one = of_vertex_.emplace_back(Vertex{.about = statics.about(0, vertex), .corners = {}});
    edges.insert(one.about.edges.begin(), one.about.edges.end());
    std::set<std::uint32_t> corners;
    for (const std::uint32_t edge : one.about.edges) {
      for (const std::uint32_t triangle : mesh->edges()[edge].triangle) {
        if (triangle == physics::k_no_triangle) continue;
        corners.insert(mesh->triangles()[triangle].begin(), mesh->triangles()[triangle].end());
      }
    }
    one.corners.assign(corners.begin(), corners.end());
  }
  edges_.assign(edges.begin(), edges.end());
}

std::vector<std::uint32_t> Influence::flat_edges(const physics::TriangleMesh& surface) const {
  std::vector<std::uint32_t> flat;
  std::ranges::copy_if(edges_, std::back_inserter(flat), [&](std::uint32_t edge) {
    return surface.edges()[edge].kind == physics::EdgeKind::flat;
  });
  return flat;
}

std::vector<physics::MarbleChange> Influence::changes(
    std::span<const Vec3> before_m, std::span<const std::uint32_t> flat_before,
    std::span<const Vec3> after_m, std::span<const std::uint32_t> flat_after) const {
  CHECK_EQ(before_m.size(), of_vertex_.size());
  CHECK_EQ(after_m.size(), of_vertex_.size());
  std::vector<physics::MarbleChange> changes;
  for (std::size_t i = 0; i < of_vertex_.size(); ++i) {
    if (before_m[i] == after_m[i]) continue;
    const Vertex& vertex = of_vertex_[i];
    physics::TouchBox box = physics::k_unmeetable;
    for (const std::uint32_t corner : vertex.corners) {
      const bool moves = corner < before_m.size();
      for (const std::span<const Vec3>& offsets_m : {before_m, after_m})
        physics::enlarge(
            box, moves ? Vec3(vertices_m_[corner] + offsets_m[corner]) : vertices_m_[corner],
            k_margin_m);
    }
    changes.push_back({.features = vertex.about.features, .box = box});
    const auto has_one_of = [&](std::span<const std::uint32_t> flat) {
      return std::ranges::any_of(flat, [&](std::uint32_t edge) {
        return std::ranges::binary_search(vertex.about.edges, edge);
      });
    };
    if (has_one_of(flat_before) || has_one_of(flat_after))
      changes.push_back({.features = vertex.about.beside, .box = box});
  }
  return changes;
}

}  // namespace sleight::worlds::spelling
