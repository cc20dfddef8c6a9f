// Compares every broad phase with the definition of overlap, in one typed suite.
#include <gtest/gtest.h>

#include <optional>

#include "tests/engines/all_pairs.h"
#include "tests/engines/sweep_and_prune.h"
#include "tests/support/property.h"
#include "tests/unit/worker/physics/broad_phase/neighbourhood.h"
#include "tests/unit/worker/physics/broad_phase/scenes.h"
#include "worker/physics/broad_phase/hierarchical_grid.h"

namespace sleight::physics {
namespace {

/// Runs a random script on one structure and compares the structure's overlaps with the definition.
template <class Structure>
class Session {
 public:
  Session(const Scene& scene, std::uint32_t bodies, std::uint64_t index)
      : scene_(scene),
        bodies_(bodies),
        dice_(index),
        periods_(scene.period_m),
        structure_({.bodies = bodies, .period_m = scene.period_m, .size_m = scene.size_m}),
        kept_(bodies),
        boxes_(bodies),
        overlaps_(std::size_t{bodies} * bodies, false) {}

  /// Returns a description of the first error, or nothing if the script passed.
  std::optional<std::string> run(int operations) {
    for (int i = 0; i < operations; ++i) {
      const std::string did = operate();
      if (const auto wrong = check()) return fmt::format("after {} {}: {}", i, did, *wrong);
    }
    return std::nullopt;
  }

  /// Number of overlaps, summed over all operations. A script without overlaps tests nothing.
  std::uint64_t overlaps_seen() const { return overlaps_seen_; }

 private:
  std::string operate() {
    if (dice_.once_in(60)) return move_all();
    const BodyId body{dice_.below(bodies_)};
    auto sink = kept_.of(body);
    std::optional<Box>& box = boxes_[body.value];
    std::string did;
    if (!box) {
      box = scene_.fresh(dice_);
      structure_.insert(body, *box, sink);
      did = fmt::format("insert {}", body);
    } else if (dice_.once_in(10)) {
      box.reset();
      structure_.remove(body, sink);
      did = fmt::format("remove {}", body);
    } else {
      box = scene_.moved(dice_, *box);
      structure_.move(body, *box, sink);
      did = fmt::format("move {}", body);
    }
    define(body.value);
    return did;
  }

  std::string move_all() {
    std::vector<Box> all(bodies_);
    const bool everybody = dice_.once_in(2);
    for (std::uint32_t body = 0; body < bodies_; ++body) {
      std::optional<Box>& box = boxes_[body];
      if (!box) continue;
      if (everybody || dice_.once_in(3)) box = scene_.moved(dice_, *box);
      all[body] = *box;
    }
    structure_.move_all(all, kept_);
    for (std::uint32_t body = 0; body < bodies_; ++body)
      define(body);
    return "move all";
  }

  /// Without periods, the reference is overlap() of box.h. With periods, the reference is overlap()
  /// of periodic.h, which has its own test.
  bool overlap_by_definition(const Box& a, const Box& b) const {
    if (scene_.period_m == std::array<double, 3>{}) return overlap(a, b);
    return overlap(a, b, periods_);
  }

  void define(std::uint32_t body) {
    for (std::uint32_t other = 0; other < bodies_; ++other) {
      const bool is = other != body && boxes_[body] && boxes_[other] &&
                      overlap_by_definition(*boxes_[body], *boxes_[other]);
      overlaps_[std::size_t{body} * bodies_ + other] = is;
      overlaps_[std::size_t{other} * bodies_ + body] = is;
    }
  }

  std::optional<std::string> check() {
    if (!kept_.complaint().empty()) return kept_.complaint();
    for (std::uint32_t body = 0; body < bodies_; ++body) {
      if (structure_.contains(BodyId{body}) != boxes_[body].has_value())
        return fmt::format("presence of {} is wrong", body);
      if (boxes_[body] && (structure_.box(BodyId{body}).low_m != boxes_[body]->low_m ||
                           structure_.box(BodyId{body}).high_m != boxes_[body]->high_m))
        return fmt::format("box of {} is wrong", body);
      // A list is complete if its length is right and all its members overlap the body.
      const auto row = overlaps_.begin() + static_cast<std::ptrdiff_t>(body * bodies_);
      const auto expected = std::count(row, row + bodies_, true);
      const std::span<const BodyId> told = kept_.neighbours(BodyId{body});
      overlaps_seen_ += told.size();
      for (const BodyId other : told) {
        if (!row[other.value]) return fmt::format("{} and {} do not overlap", body, other);
      }
      if (static_cast<std::ptrdiff_t>(told.size()) != expected)
        return fmt::format("{} has {} overlaps, not {}", body, told.size(), expected);
    }
    return std::nullopt;
  }

  const Scene& scene_;
  std::uint32_t bodies_;
  Dice dice_;
  Periods periods_;
  Structure structure_;
  Neighbourhood kept_;
  std::vector<std::optional<Box>> boxes_;
  std::vector<bool> overlaps_;
  std::uint64_t overlaps_seen_ = 0;
};

template <class Structure>
class BroadPhaseSuite : public ::testing::Test {};
using Structures = ::testing::Types<AllPairs, SweepAndPrune, HierarchicalGrid>;
TYPED_TEST_SUITE(BroadPhaseSuite, Structures);

TYPED_TEST(BroadPhaseSuite, TellsOverlapsExactlyInFewBodies) {
  // Goal: a broad phase reports exactly the pairs of bodies whose boxes overlap. Each pair is
  // reported once (broad_phase.h, invariants 1 and 2). Method: for each kind of scene, do 8000
  // random operations: insert, move or remove a body, or move all bodies. After each operation,
  // compare all overlaps with the definition.
  for (std::size_t i = 0; i < scenes().size(); ++i) {
    const Scene& scene = scenes()[i];
    Session<TypeParam> session(scene, 20, i);
    EXPECT_EQ(session.run(8000), std::nullopt) << scene.name;
    EXPECT_GT(session.overlaps_seen(), 8000U) << scene.name;
  }
}

TYPED_TEST(BroadPhaseSuite, TellsOverlapsExactlyInManyBodies) {
  // Goal: a broad phase also reports the right overlaps if there are so many bodies that the grid
  // searches its cells.
  for (std::size_t i = 0; i < scenes().size(); ++i) {
    Session<TypeParam> session(scenes()[i], 200, 100 + i);
    EXPECT_EQ(session.run(static_cast<int>(property::of_tier(200, 800))), std::nullopt)
        << scenes()[i].name;
  }
}

TYPED_TEST(BroadPhaseSuite, HoldsNoBodies) {
  // Goal: a broad phase accepts a world without bodies.
  TypeParam structure({.bodies = 0});
  Neighbourhood told(0);
  structure.move_all({}, told);
  EXPECT_EQ(told.complaint(), "");
}

TYPED_TEST(BroadPhaseSuite, RefusesWhatIsNotABox) {
  // Goal: an inverted box or a NaN coordinate stops the process, because such a box would silently
  // miss overlaps. The process also stops if a caller moves an absent body, or inserts a present or
  // unknown body.
  TypeParam structure({.bodies = 2});
  NoOverlapSink sink;
  const Box box{{0, 0, 0}, {1, 1, 1}};
  EXPECT_DEATH(structure.move(BodyId{0}, box, sink), "check failed");
  structure.insert(BodyId{0}, box, sink);
  EXPECT_DEATH(structure.insert(BodyId{0}, box, sink), "check failed");
  EXPECT_DEATH(structure.insert(BodyId{2}, box, sink), "check failed");
  EXPECT_DEATH(structure.move(BodyId{0}, Box{{0, 2, 0}, {1, 1, 1}}, sink), "check failed");
  EXPECT_DEATH(
      structure.move(BodyId{0}, Box{{0, 0, std::numeric_limits<float>::quiet_NaN()}, {1, 1, 1}},
                     sink),
      "check failed");
}

// Each of these structures adds one fault to a correct structure.

template <class Faults>
class Faulty {
 public:
  explicit Faulty(const BroadPhaseOptions& options) : right_(Faults::given(options)) {}
  const Box& box(BodyId body) const { return boxes_.at(body.value); }
  bool contains(BodyId body) const { return right_.contains(body); }
  void insert(BodyId body, const Box& box, auto& sink) {
    remember(body, box);
    auto faulty = Faults::sink(sink);
    right_.insert(body, Faults::seen(box), faulty);
  }
  void move(BodyId body, const Box& box, auto& sink) {
    remember(body, box);
    auto faulty = Faults::sink(sink);
    right_.move(body, Faults::seen(box), faulty);
  }
  void remove(BodyId body, auto& sink) { right_.remove(body, sink); }
  void move_all(std::span<const Box> boxes, auto& sink) {
    std::vector<Box> seen;
    for (const Box& box : boxes)
      seen.push_back(Faults::seen(box));
    boxes_.assign(boxes.begin(), boxes.end());
    right_.move_all(seen, sink);
  }

 private:
  void remember(BodyId body, const Box& box) {
    boxes_.resize(std::max<std::size_t>(boxes_.size(), body.value + 1));
    boxes_[body.value] = box;
  }
  AllPairs right_;
  std::vector<Box> boxes_;
};

struct NoFault {
  static BroadPhaseOptions given(const BroadPhaseOptions& options) { return options; }
  static Box seen(const Box& box) { return box; }
  static auto& sink(auto& sink) { return sink; }
};
struct OpenBoxes : NoFault {  // ignores overlaps of boxes that only touch
  static Box seen(Box box) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      box.high_m[axis] = std::max(box.low_m[axis], std::nextafter(box.high_m[axis], -1e30F));
    return box;
  }
};
struct NoPeriods : NoFault {
  static BroadPhaseOptions given(BroadPhaseOptions options) {
    options.period_m = {};
    return options;
  }
};
template <class Sink>
struct Swallowing {  // drops every end of an overlap with body 7
  Sink& to;
  void begin(BodyId other) { to.begin(other); }
  void end(BodyId other) {
    if (other.value != 7) to.end(other);
  }
  std::span<const BodyId> neighbours() const { return to.neighbours(); }
};
struct ForgetsEnds : NoFault {
  template <class Sink>
  static auto sink(Sink& sink) {
    return Swallowing<Sink>{sink};
  }
};
template <class Sink>
struct Repeating {  // reports each begin with body 7 twice
  Sink& to;
  void begin(BodyId other) {
    to.begin(other);
    if (other.value == 7) to.begin(other);
  }
  void end(BodyId other) { to.end(other); }
  std::span<const BodyId> neighbours() const { return to.neighbours(); }
};
struct TellsTwice : NoFault {
  template <class Sink>
  static auto sink(Sink& sink) {
    return Repeating<Sink>{sink};
  }
};

template <class Structure>
int scenes_failed() {
  int failed = 0;
  for (std::size_t i = 0; i < scenes().size(); ++i) {
    if (Session<Structure>(scenes()[i], 20, i).run(2000)) ++failed;
  }
  return failed;
}

TEST(BroadPhaseSuiteItself, CatchesFaultyStructures) {
  // Goal: the suite rejects faulty broad phases. Method: run the random operations on a correct
  // broad phase and on four faulty broad phases.
  EXPECT_EQ(scenes_failed<Faulty<NoFault>>(), 0);
  EXPECT_GE(scenes_failed<Faulty<OpenBoxes>>(), 1);
  EXPECT_GE(scenes_failed<Faulty<NoPeriods>>(), 6);
  const auto all = static_cast<int>(scenes().size());
  EXPECT_EQ(scenes_failed<Faulty<ForgetsEnds>>(), all);
  EXPECT_EQ(scenes_failed<Faulty<TellsTwice>>(), all);
}

}  // namespace
}  // namespace sleight::physics
