// Neighbour lists like the simulator's lists. The lists also check every reported overlap.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "worker/physics/broad_phase/broad_phase.h"

namespace sleight::physics {

class Neighbourhood {
 public:
  explicit Neighbourhood(std::uint32_t bodies) : neighbours_(bodies) {}

  void begin(BodyId lower, BodyId higher) {
    if (lower >= higher) complain("begin", lower, higher, "not in order");
    meet(lower, higher);
  }
  void end(BodyId lower, BodyId higher) {
    if (lower >= higher) complain("end", lower, higher, "not in order");
    part(lower, higher);
  }
  std::span<const BodyId> neighbours(BodyId body) const { return neighbours_[body.value]; }

  struct Of {
    Neighbourhood& all;
    BodyId body;
    void begin(BodyId other) { all.meet(body, other); }
    void end(BodyId other) { all.part(body, other); }
    std::span<const BodyId> neighbours() const { return all.neighbours(body); }
  };
  Of of(BodyId body) { return {*this, body}; }

  /// The first impossible report. Empty if there was none.
  const std::string& complaint() const { return complaint_; }

 private:
  void meet(BodyId a, BodyId b) {
    if (a == b) return complain("begin", a, b, "of a body with itself");
    if (std::ranges::count(neighbours_[a.value], b) != 0) {
      return complain("begin", a, b, "had begun");
    }
    neighbours_[a.value].push_back(b);
    neighbours_[b.value].push_back(a);
  }
  void part(BodyId a, BodyId b) {
    if (std::erase(neighbours_[a.value], b) != 1 || std::erase(neighbours_[b.value], a) != 1)
      complain("end", a, b, "had not begun");
  }
  void complain(const char* what, BodyId a, BodyId b, const char* why) {
    if (complaint_.empty()) complaint_ = fmt::format("{} of {} and {}: {}", what, a, b, why);
  }

  std::vector<std::vector<BodyId>> neighbours_;
  std::string complaint_;
};
static_assert(PairSink<Neighbourhood> && OverlapSink<Neighbourhood::Of>);

}  // namespace sleight::physics
