#include "tests/thesis/proportions/draws.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "common/base/check.h"
#include "common/base/error.h"
#include "common/random/discrete_distributions.h"
#include "tests/statistical/support/run_serially.h"
#include "worker/run/catalogue.h"
#include "worker/worlds/spelling/pouring_stages.h"
#include "worker/worlds/spelling/request.h"

namespace sleight::thesis {
namespace {

namespace spelling = worlds::spelling;

class Run {
 public:
  explicit Run(const std::string& text) {
    request_ = read(text, catalogue_.bindings());
    world_ = std::make_unique<spelling::StagedSpelling>(
        request::parameters_of<spelling::Parameters>(request_));
    const run::WorldEntry& entry = catalogue_.world_of(request_);
    plan_ = run::make_plan(request_, entry);
    worker_ = entry.make_worker(request_);
  }

  const request::SamplerParameters& sampler() const { return request_.sampler; }
  std::uint32_t balls() const { return world_->balls(); }
  const spelling::StagedSpelling& world() const { return *world_; }
  bool satisfies(const spelling::State& state) const {
    return world_->satisfied(world_->simulate(state));
  }
  plan::Draws draws() const { return plan_->draws(); }
  std::uint64_t scans_before_draws() const { return request::scans_before_draws(request_.sampler); }

  /// Calls `observe(chain, scan, record)` for each scan at inverse temperature 1.
  template <class Observe>
  void carry_out(const Observe& observe) {
    statistical::run_serially(*plan_, *worker_, [&](const plan::UnitResult& result) {
      if (result.unit.searches()) return;
      for (std::uint64_t nth = 0; nth < result.scans.size(); ++nth) {
        const plan::ScanRecord& record = result.scans[nth];
        if (record.inverse_temperature == 1)
          observe(result.unit.replica.chain.value, result.unit.first_scan.value + nth, record);
      }
    });
  }

  Values values_of(const plan::ScanRecord& record) const {
    const auto state = world_->decode(record.state);
    CHECK(state.has_value());
    const auto outcome = world_->simulate(*state);
    const std::uint32_t balls = world_->balls();
    const std::uint32_t middle = balls / 2;
    const auto bin = static_cast<std::size_t>(outcome.filling[middle]);
    return {static_cast<double>(world_->helped_balls(*state, outcome)),
            static_cast<double>(outcome.filling.front()),
            static_cast<double>(outcome.filling.back()),
            record.log_prior,
            state->offsets_m[state->offsets_m.size() / 2].z(),
            state->drops_m.back().x(),
            (state->drops_m[middle] - world_->middle_m(bin)).norm()};
  }

 private:
  static request::DirectionRequest read(const std::string& text,
                                        const std::vector<request::WorldBinding>& worlds) {
    auto request = request::read_request(text, "request", worlds);
    if (!request) throw base::Error("the request has an error: " + request.error().front().message);
    return std::move(request.value());
  }

  const run::Catalogue catalogue_;
  request::DirectionRequest request_;
  std::unique_ptr<spelling::StagedSpelling> world_;
  std::unique_ptr<plan::Plan> plan_;
  std::unique_ptr<plan::UnitWorker> worker_;
};

}  // namespace

std::uint64_t satisfying_throws(const std::string& request_text, std::uint64_t throws) {
  const Run run(request_text);
  std::uint64_t satisfying = 0;
  for (std::uint64_t number = 0; number < throws; ++number) {
    random::Stream stream({.seed = run.sampler().seed, .purpose = random::Purpose::prior}, number);
    if (run.satisfies(run.world().draw_throw(stream))) ++satisfying;
  }
  return satisfying;
}

std::uint32_t balls_of(const std::string& request_text) {
  return Run(request_text).balls();
}

Series satisfying_draws(const std::string& request_text, std::uint64_t first_scan) {
  Run run(request_text);
  Series series(run.sampler().chains);
  run.carry_out([&](std::uint32_t chain, std::uint64_t scan, const plan::ScanRecord& record) {
    if (scan >= first_scan && record.satisfied) series[chain].push_back(run.values_of(record));
  });
  return series;
}

std::vector<Values> takes_of(const std::string& request_text) {
  Run run(request_text);
  const std::uint64_t last = run.sampler().relax_scans.value();
  std::vector<Values> takes;
  run.carry_out([&](std::uint32_t, std::uint64_t scan, const plan::ScanRecord& record) {
    if (scan == last && record.satisfied) takes.push_back(run.values_of(record));
  });
  return takes;
}

std::vector<std::vector<double>> helped_by_scan(const std::string& request_text) {
  Run run(request_text);
  std::vector<std::vector<double>> helped;
  run.carry_out([&](std::uint32_t, std::uint64_t scan, const plan::ScanRecord& record) {
    if (helped.size() <= scan) helped.resize(scan + 1);
    if (record.satisfied) helped[scan].push_back(run.values_of(record).front());
  });
  return helped;
}

namespace {

using Where = std::pair<std::uint64_t, std::uint32_t>;  ///< (scan, chain)
using Satisfying = std::map<Where, plan::ScanRecord>;

/// For a plan of tours: finds the scans that count as solutions, and keeps only satisfying scans
/// that are draws.
void count_parts(const plan::Draws& draws, std::vector<Where>& counted, Satisfying& satisfying) {
  for (const plan::DrawPart& part : draws.parts)
    for (std::uint32_t chain = 0; chain < part.counted.size(); ++chain)
      if (part.counted[chain]) counted.emplace_back(*part.counted[chain], chain);
  std::erase_if(satisfying, [&](const auto& entry) {
    return std::ranges::none_of(draws.parts, [&](const plan::DrawPart& part) {
      return entry.first.first - part.first_scan < part.count;
    });
  });
}

/// For a plan without tours: counts the first satisfying scan of each lineage that began after the
/// burn-in.
void count_lineages(std::uint64_t before, std::vector<Where>& counted, Satisfying& satisfying) {
  std::erase_if(satisfying, [&](const auto& entry) { return entry.first.first < before; });
  std::set<std::pair<std::uint32_t, std::uint64_t>> lineages;
  for (const auto& [where, record] : satisfying)
    if (plan::scan_of_lineage(record.lineage) >= before &&
        lineages.emplace(where.second, record.lineage).second)
      counted.push_back(where);
}

}  // namespace

Counted counted_solutions(const std::string& request_text) {
  Run run(request_text);
  Satisfying satisfying;
  run.carry_out([&](std::uint32_t chain, std::uint64_t scan, const plan::ScanRecord& record) {
    if (record.satisfied) satisfying.emplace(Where{scan, chain}, record);
  });
  std::vector<Where> counted_at;
  const plan::Draws draws = run.draws();
  if (draws.parts.empty()) {
    count_lineages(run.scans_before_draws(), counted_at, satisfying);
  } else {
    count_parts(draws, counted_at, satisfying);
  }
  Counted counted{.has_run = true, .solutions = {}, .any_scan = {}};
  for (const Where& where : counted_at)
    counted.solutions.push_back(run.values_of(satisfying.at(where)));
  if (!satisfying.empty()) {
    random::Stream stream({.seed = run.sampler().seed, .purpose = random::Purpose::prior}, 0);
    const auto any = random::UniformInteger{.count = satisfying.size()}.draw(stream);
    counted.any_scan.push_back(
        run.values_of(std::next(satisfying.begin(), static_cast<std::ptrdiff_t>(any))->second));
  }
  return counted;
}

}  // namespace sleight::thesis
