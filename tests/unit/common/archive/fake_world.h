// A made-up world and run for the archive's tests. Every value is a function of (seed, chain,
// scan), so every test, process and file format can be compared value by value.
//
// The state is an 8-byte key. The variables, the likeness and the recording are computed from the
// key. The three variables have zero, one and two dimensions. Some entries are NaN.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/archive/layout.h"
#include "common/archive/run_view.h"
#include "common/archive/world_layout.h"
#include "common/base/check.h"
#include "tests/support/numbers.h"

namespace sleight::archive::testing {

/// Computes arbitrary bits from x (the finaliser of SplitMix64).
inline std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
  x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
  return x ^ (x >> 31);
}

inline double unit_of(std::uint64_t x) {
  return static_cast<double>(mixed(x) >> 11) * 0x1p-53;
}

class FakeReader : public StateReader {
 public:
  explicit FakeReader(std::string warning = {}) {
    const Dimension collision{"collision", 3};
    const Dimension axis{"axis", 2};
    layout_ = {.world = "fake",
               .variables = {{"height_m", {}, "m", "height of the release"},
                             {"normal_rad", {collision}, "rad", "turn of the normal"},
                             {"spin_radps", {collision, axis}, "rad/s", "spin after a collision"}},
               .outcomes = {{"landing_m", {}, "m", "where it lands"},
                            {"bounces", {}, "1", "how often it bounces"}},
               .proposal_kinds = {"all", "one_normal"},
               .warning = std::move(warning)};
    layout_.variables[0].prior_mean = {0.5};
    layout_.variables[0].prior_sd = {0.25};
    scene_ = {.features =
                  {{.name = "ball 1", .twin_of = 0},
                   {.name = "ball 2", .twin_of = 0},
                   {.name = "table", .kind = scene::FeatureKind::fixed, .twin_of = 2},
                   {.name = "target", .kind = scene::FeatureKind::wanted, .twin_of = 3, .body = 1}},
              .parts = {{.feature = 0, .shape = scene::Shape::sphere, .size_m = {0.1, 0.1, 0.1}},
                        {.feature = 1, .shape = scene::Shape::sphere, .size_m = {0.1, 0.1, 0.1}},
                        {.feature = 2, .shape = scene::Shape::surface, .size_m = {2, 2, 0.25}},
                        {.feature = 2, .shape = scene::Shape::mesh, .triangles = 1},
                        {.feature = 3, .shape = scene::Shape::disc, .size_m = {0.2, 0.2, 0}}},
              .vertices = {{.place_m = {0, 0, 0}}, {.place_m = {1, 0, 0}}, {.place_m = {0, 1, 0}}},
              .triangles = {{0, 1, 2}},
              .has_own_parts = true,
              .has_own_points = true,
              .low_m = {-1, -1, 0},
              .high_m = {1, 1, 1}};
  }

  const WorldLayout& layout() const override { return layout_; }

  std::vector<double> variables(base::BytesView state) const override {
    const std::uint64_t key = key_of(state);
    std::vector<double> values;
    for (std::uint64_t i = 0; i < 10; ++i) {
      const bool inactive = i == 3 && key % 4 == 0;
      values.push_back(inactive ? std::numeric_limits<double>::quiet_NaN() : unit_of(key + i));
    }
    return values;
  }

  std::vector<double> likeness(base::BytesView state) const override {
    return {unit_of(key_of(state))};
  }
  double likeness_distance(std::span<const double> a, std::span<const double> b) const override {
    return std::abs(a[0] - b[0]);
  }

  /// Returns up to four segments, which belong to two bodies in turn.
  Motion play(base::BytesView state) const override {
    const std::uint64_t key = key_of(state);
    Motion motion;
    for (std::uint64_t i = 0; i < key % 5; ++i) {
      const bool is_hit = i >= 2;
      motion.segments.push_back(
          {.body = static_cast<std::uint32_t>(i % 2),
           .start_s = static_cast<double>(i) + unit_of(key ^ (i << 32)),
           .mode = is_hit ? motion::Mode::rolling : motion::Mode::flying,
           .cause = is_hit ? motion::Cause::hit : motion::Cause::start,
           .partner = is_hit ? 2 : motion::k_no_partner,
           .position_m = {unit_of(key + 1), unit_of(key + 2), unit_of(key + 3)},
           .velocity_mps = {unit_of(key + 4), 0, -1},
           .acceleration_mps2 = {0, 0, -9.81},
           .orientation = math::quaternion_of_rotation_vector({unit_of(key + 5), 0, 1}),
           .angular_velocity_radps = {0, unit_of(key + 6), 0}});
    }
    return motion;
  }

  const scene::Scene& scene() const override { return scene_; }

  scene::Variation variation(base::BytesView state,
                             std::span<const motion::Segment> segments) const override {
    const std::uint64_t key = key_of(state);
    scene::Variation own;
    if (key % 2 == 0)
      own.parts.push_back({.feature = 2, .shape = scene::Shape::box, .size_m = {1, 1, 0.1}});
    for (std::size_t i = 0; i < segments.size(); ++i)
      own.points.push_back({.i = static_cast<std::int32_t>(i),
                            .j = -3,
                            .height_m = unit_of(key + i),
                            .restitution = 0.5,
                            .friction = 0.25});
    return own;
  }

  std::vector<double> prior_draw(std::uint64_t nth) const override {
    return variables(state_of(mixed(nth)));
  }

  std::vector<double> log_priors_of_throws(std::size_t count) const override {
    std::vector<double> all;
    for (std::uint64_t nth = 0; nth < count; ++nth)
      all.push_back(-unit_of(nth));
    return all;
  }

  static base::Bytes state_of(std::uint64_t key) {
    base::ByteWriter writer;
    writer.put(key);
    return writer.take();
  }

 protected:
  static std::uint64_t key_of(base::BytesView state) {
    const auto key = base::ByteReader(state).get<std::uint64_t>();
    CHECK(key.has_value());
    return *key;
  }

  WorldLayout layout_;

 private:
  scene::Scene scene_;
};

/// A FakeReader whose collisions have names, as users may choose them.
class NamedReader final : public FakeReader {
 public:
  NamedReader() {
    for (const std::size_t i : {1, 2})
      layout_.variables[i].dims[0].names = names();
  }
  static std::vector<std::string> names() {
    return {"first", "a \"gro\xc3\x9f\", [b]", std::string(k_index_name_bytes_max, 'x')};
  }
};

struct FakeRunOptions {
  std::uint64_t seed = 1;
  std::uint32_t chains = 3;
  std::uint64_t scans = 101;
  std::uint64_t thin = 10;
  double satisfied_share = 0.3;
  std::uint64_t lineages = 7;  ///< few, so that lineages return as replicas do under tempering
  std::uint64_t finds = 0;     ///< finds of a search, one from every second start
  std::uint64_t relax_scans = 0;
  std::uint64_t prior_draws = 50;
};

class FakeRun : public RunView {
 public:
  explicit FakeRun(const FakeRunOptions& options) : options_(options) {}

  std::uint32_t chains() const override { return options_.chains; }
  std::uint64_t draws() const override { return options_.scans; }
  std::uint64_t finds() const override { return options_.finds; }
  std::uint64_t relax_scans() const override { return options_.relax_scans; }
  std::uint64_t prior_draws() const override { return options_.prior_draws; }
  void for_each_prior_draw(
      const std::function<void(std::uint64_t, const plan::ScanRecord&)>& visit) const override {
    for (std::uint64_t nth = 0; nth < options_.prior_draws; ++nth) {
      visit(nth, {.log_prior = -unit_of(nth + 1),
                  .log_constraint =
                      nth % 3 == 0 ? -std::numeric_limits<double>::infinity() : -unit_of(nth + 2),
                  .satisfied = nth % 11 == 1,
                  .outcome = {unit_of(nth), static_cast<double>(nth % 7)}});
    }
  }
  void for_each_find(
      const std::function<void(std::uint64_t, const plan::ScanRecord&)>& visit) const override {
    for (std::uint64_t i = 0; i < options_.finds; ++i) {
      plan::ScanRecord found = record({9}, options_.thin * i);
      found.satisfied = true;
      visit(2 * i, found);
    }
  }

  void for_each_draw(
      base::ChainId chain,
      const std::function<void(base::ScanIndex, const plan::ScanRecord&)>& visit) const override {
    plan::ScanRecord record;
    for (std::uint64_t scan = 0; scan < options_.scans; ++scan) {
      fill(chain, scan, record);
      visit({scan}, record);
    }
  }

  plan::ScanRecord record(base::ChainId chain, std::uint64_t scan) const {
    plan::ScanRecord record;
    fill(chain, scan, record);
    return record;
  }

 private:
  void fill(base::ChainId chain, std::uint64_t scan, plan::ScanRecord& record) const {
    const std::uint64_t key =
        mixed(mixed(options_.seed + (std::uint64_t{chain.value} << 40)) + scan);
    record.satisfied = unit_of(key + 1) < options_.satisfied_share;
    record.log_prior = -10 * unit_of(key + 2);
    record.log_constraint =
        key % 16 == 0 ? -std::numeric_limits<double>::infinity() : -5 * unit_of(key + 3);
    record.lineage = mixed(key) % options_.lineages;
    const auto proposals = static_cast<std::uint32_t>(key % 3);
    record.proposed = {scan == 0 ? 0 : proposals, scan == 0 ? 0 : 4 - proposals};
    record.accepted = {record.proposed[0] / 2, record.proposed[1] / 2};
    record.outcome = {unit_of(key + 4), static_cast<double>(key % 9)};
    record.state.clear();
    // There are few different keys, so some animations are equal and others only look alike.
    if (record.satisfied || scan % options_.thin == 0) {
      record.state = FakeReader::state_of(mixed(key) % 64);
    }
  }

  FakeRunOptions options_;
};

/// A tempered FakeRun of two replicas. Its report has two tables. In chain 0, replica 1 has no
/// state.
class FakeTemperedRun final : public FakeRun {
 public:
  explicit FakeTemperedRun(const FakeRunOptions& options) : FakeRun(options) {}
  std::uint32_t replicas() const override { return 2; }
  void for_each_replica(base::ChainId chain, std::uint64_t thin,
                        const std::function<void(base::ReplicaId, base::ScanIndex,
                                                 const plan::ScanRecord&)>& visit) const override {
    plan::ScanRecord first = record(chain, thin);
    first.inverse_temperature = 0.25;
    visit({0}, {thin}, first);
    if (chain.value > 0) visit({1}, {2 * thin}, record(chain, 2 * thin));
  }
  plan::Report report() const override {
    return {.tables = {{.name = "barrier",
                        .meaning = "a number for each round",
                        .dims = {{"chain", 3}, {"round", 2}},
                        .values = {1, 2, 3, 4, 5, k_nan}},
                       {.name = "acceptance",
                        .meaning = "a number for each kind",
                        .dims = {{"chain", 3}, {"proposal_kind", 2}},
                        .values = {0, 1, 2, 3, 4, 5}}},
            .warning = "draws have weights"};
  }
};

inline ArchiveOptions options_for(const FakeRunOptions& run) {
  return {.request_text =
              "# a request, with a letter beyond ASCII: \xc3\xa9\n[world]\nkind = \"fake\"\n",
          .thin = run.thin,
          .keep_max = 20,
          .keep_per_lineage = 3,
          .min_distance = 0.05,
          .inference_library_version = "0.0.0+test",
          .results_version = "0123456789abcdef",
          .run_id = "fake run"};
}

template <class Reader = FakeReader>
std::function<void(Sink&)> filler(const FakeRunOptions& run) {
  return [run](Sink& sink) { write_archive(FakeRun(run), Reader(), options_for(run), sink); };
}

}  // namespace sleight::archive::testing
