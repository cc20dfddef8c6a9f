#include "service/daemon/request_cost.h"

#include <fmt/format.h>

#include <limits>

#include "common/events/progress.h"

namespace sleight::daemon {
namespace {

using events::grouped;

/// The product, or the maximum if it overflows.
std::uint64_t product(std::uint64_t a, std::uint64_t b) {
  std::uint64_t whole = 0;
  return __builtin_mul_overflow(a, b, &whole) ? std::numeric_limits<std::uint64_t>::max() : whole;
}

bool is_tempered(request::Method method) {
  return method == request::Method::parallel_tempering ||
         method == request::Method::simulated_tempering ||
         method == request::Method::tempered_transitions ||
         method == request::Method::annealed_importance;
}

/// Scans of each chain. None: the stop rule depends on results.
std::optional<std::uint64_t> scans_of(const request::DirectionRequest& request) {
  if (request.stop.scans) return *request.stop.scans;
  if (!request.stop.rounds) return std::nullopt;
  const std::uint64_t doubled = (std::uint64_t{1} << *request.stop.rounds) - 1;
  return product(request.sampler.round_scans, doubled);
}

/// "4 chains", "1 chain".
std::string counted(std::uint64_t count, const char* what) {
  return fmt::format("{} {}{}", grouped(count), what, count == 1 ? "" : "s");
}

rpc::Refusal too_dear(const std::string& sum, std::uint64_t most, const char* what,
                      const char* setting, const char* key) {
  return {
      .kind = rpc::RefusalKind::limit,
      .sentence = fmt::format("The request needs {}, but this service's limit per job is {} {}.",
                              sum, grouped(most), what),
      .what_to_do = fmt::format("Reduce `{}`, or ask the service's administrator to raise {}.", key,
                                setting)};
}

}  // namespace

RequestCost cost_of(const request::DirectionRequest& request) {
  const request::SamplerParameters& sampler = request.sampler;
  RequestCost cost{.states = sampler.chains};
  std::string factors = counted(sampler.chains, "chain");
  if (is_tempered(sampler.method)) {
    const std::uint64_t replicas = sampler.replicas.value_or(request::k_chosen_replicas_max);
    cost.states = product(cost.states, replicas);
    factors +=
        fmt::format(" x {}{} temperatures", sampler.replicas ? "" : "up to ", grouped(replicas));
  } else if (request::makes_islands(sampler.method)) {
    const std::uint64_t particles = sampler.particles.value_or(request::k_particles);
    cost.states = product(cost.states, particles);
    factors += fmt::format(" x {} particles", grouped(particles));
  }
  cost.states_sum = fmt::format("{} = {} states", factors, grouped(cost.states));
  if (const auto scans = scans_of(request); scans && sampler.chains > 0) {
    cost.simulations = product(cost.states, product(sampler.iterations_per_scan, *scans));
    cost.simulations_sum = fmt::format(
        "{} x {} per scan x {} = {}", factors, counted(sampler.iterations_per_scan, "iteration"),
        counted(*scans, "scan"), counted(*cost.simulations, "simulation"));
  }
  return cost;
}

std::optional<rpc::Refusal> beyond_limits(const RequestCost& cost, const RequestLimits& limits) {
  if (limits.states > 0 && cost.states > limits.states)
    return too_dear(cost.states_sum, limits.states, "states", "limits.states", "sampler.chains");
  if (limits.simulations > 0 && cost.simulations && *cost.simulations > limits.simulations) {
    return too_dear(cost.simulations_sum, limits.simulations, "simulations", "limits.simulations",
                    "[stop]");
  }
  return std::nullopt;
}

}  // namespace sleight::daemon
