#include "common/request/common_sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <vector>

namespace sleight::request {
namespace {

static_assert(k_burn_in_rounds == 4 && k_lanes == 8, "said in the help");

/// A key that a method doesn't have would do nothing in silence.
void refuse_other_methods_keys(Binder& sampler, Method method) {
  if (!sampler.valid("method")) return;
  const bool is_plain = method == Method::metropolis_hastings;
  const bool burns_in = !is_plain && method != Method::parallel_tempering;
  const bool ascends = method == Method::annealed_importance;
  const bool has_steps = ascends || method == Method::tempered_transitions;
  const auto refuse = [&](std::string_view key, bool has, std::string_view methods) {
    if (has || !sampler.given(key)) return;
    sampler.error(key, fmt::format("goes with method {}", methods));
  };
  refuse("replicas", !is_plain, "\"parallel_tempering\" and those that burn in with it");
  refuse("ladder_power", !is_plain, "\"parallel_tempering\" and those that burn in with it");
  refuse("burn_in_rounds", burns_in,
         "\"simulated_tempering\", \"tempered_transitions\" or \"annealed_importance\"");
  refuse("lanes", ascends, "\"annealed_importance\"");
  refuse("steps_per_level", has_steps, "\"tempered_transitions\" or \"annealed_importance\"");
}

/// A tempered transition goes through all temperatures, down and up again, and has only so many
/// iteration numbers of its own.
void check_excursions(Binder& sampler, const SamplerParameters& p) {
  if (p.method != Method::tempered_transitions || !sampler.valid("method")) return;
  for (const char* key : {"replicas", "steps_per_level", "iterations_per_scan"}) {
    if (!sampler.valid(key)) return;
  }
  const std::uint64_t levels = p.replicas.value_or(k_chosen_replicas_max);
  const std::uint64_t steps =
      2 * levels * p.steps_per_level.value_or(1) * std::uint64_t{p.iterations_per_scan};
  if (steps < k_excursion_iterations_max) return;
  sampler.error("iterations_per_scan",
                fmt::format("a tempered transition has {} iterations (2 x {} temperatures x "
                            "steps_per_level x iterations_per_scan), which must stay below {}",
                            steps, levels, k_excursion_iterations_max));
}

/// What comes before the scans that are judged, and what excursions and ascents consist of.
void bind_what_some_methods_have(Binder& sampler, SamplerParameters& p) {
  sampler.optional_integer("anneal_scans", p.anneal_scans,
                           {.minimum = 1,
                            .maximum = 1000000,
                            .unit = "scans",
                            .help = "simulated annealing from the prior before all else"});
  sampler.optional_integer("burn_in_rounds", p.burn_in_rounds,
                           {.minimum = 1,
                            .maximum = 20,
                            .unit = "rounds",
                            .help = "of parallel tempering, to find temperatures, before "
                                    "simulated_tempering, tempered_transitions and "
                                    "annealed_importance; 4 if absent"});
  sampler.optional_integer("lanes", p.lanes,
                           {.minimum = 1,
                            .maximum = 1024,
                            .help = "ascents beside each other, of a chain: annealed_importance; "
                                    "8 if absent"});
  sampler.optional_integer("steps_per_level", p.steps_per_level,
                           {.minimum = 1,
                            .maximum = 1000,
                            .unit = "steps",
                            .help = "from one temperature to the next: tempered_transitions, "
                                    "annealed_importance; 1 if absent"});
}

void bind_sampler(Binder& sampler, SamplerParameters& p) {
  static constexpr std::array k_methods{
      Named<Method>{"metropolis_hastings", Method::metropolis_hastings},
      Named<Method>{"parallel_tempering", Method::parallel_tempering},
      Named<Method>{"simulated_tempering", Method::simulated_tempering},
      Named<Method>{"tempered_transitions", Method::tempered_transitions},
      Named<Method>{"annealed_importance", Method::annealed_importance}};
  sampler.choice("method", p.method, std::span<const Named<Method>>(k_methods),
                 "how animations are drawn");
  sampler.integer(
      "chains", p.chains,
      {.minimum = 1, .maximum = k_chains_max, .help = "chains, independent of each other"});
  sampler.optional_integer("replicas", p.replicas,
                           {.minimum = 2,
                            .maximum = k_replicas_max,
                            .help = "temperatures of a ladder; chosen from its barrier if absent"});
  sampler.optional_integer("ladder_power", p.ladder_power,
                           {.minimum = 1,
                            .maximum = k_ladder_power_max,
                            .help = "of a ladder's first round, also in a burn-in: of n inverse "
                                    "temperatures (12 unless replicas says so) the i-th is (i / (n "
                                    "- 1))^ladder_power; 6 if absent. Later ones are learnt"});
  sampler.integer("seed", p.seed,
                  {.minimum = 0,
                   .maximum = static_cast<std::int64_t>(k_seed_max),
                   .help = "another seed, another run; the same seed, the same bits"});
  sampler.integer("iterations_per_scan", p.iterations_per_scan,
                  {.minimum = 1,
                   .maximum = 1000000,
                   .unit = "proposals",
                   .help = "proposals that make a scan"});
  sampler.integer("round_scans", p.round_scans,
                  {.minimum = 1,
                   .maximum = k_round_scans_max,
                   .unit = "scans",
                   .help = "length of the first round; each later one is twice as long"});
  bind_what_some_methods_have(sampler, p);
  refuse_other_methods_keys(sampler, p.method);
  check_excursions(sampler, p);
}

void bind_stop(Binder& stop, StopRule& p) {
  stop.optional_integer("scans", p.scans,
                        {.minimum = 1,
                         .maximum = static_cast<std::int64_t>(k_scans_max),
                         .unit = "scans",
                         .help = "ends after so many scans of each chain, annealing and burn-in "
                                 "included"});
  stop.optional_integer("rounds", p.rounds,
                        {.minimum = 1,
                         .maximum = k_rounds_max,
                         .unit = "rounds",
                         .help = "ends after so many rounds of each chain"});
  stop.optional_integer("independent_solutions", p.independent_solutions,
                        {.minimum = 1,
                         .maximum = k_independent_solutions_max,
                         .help = "ends when so many lineages have a satisfying animation"});
}

void bind_output(Binder& output, OutputParameters& p) {
  output.integer("thin", p.thin,
                 {.minimum = 1,
                  .maximum = 1000000000,
                  .unit = "scans",
                  .help = "1 keeps every scan's state, 10 every tenth"});
  output.integer("keep_max", p.keep_max,
                 {.minimum = 0,
                  .maximum = 1000000,
                  .unit = "animations",
                  .help = "at most so many satisfying animations are kept"});
  output.integer("keep_per_lineage", p.keep_per_lineage,
                 {.minimum = 0,
                  .maximum = 1000,
                  .unit = "animations",
                  .help = "of these, at most so many from one lineage"});
  output.number("min_distance", p.min_distance,
                {.minimum = 0,
                 .maximum = 1e6,
                 .unit = "units of likeness",
                 .help = "least distance of two that are kept, as the world measures likeness"});
}

}  // namespace

SectionBinders::SectionBinders(const Document& document, Diagnostics& diagnostics)
    : world("world", document.find("world"), diagnostics),
      constraint("constraint", document.find("constraint"), diagnostics),
      sampler("sampler", document.find("sampler"), diagnostics),
      stop("stop", document.find("stop"), diagnostics),
      output("output", document.find("output"), diagnostics) {}

const WorldBinding* bind_sections(SectionBinders& sections, std::span<const WorldBinding> worlds,
                                  DirectionRequest& request) {
  CHECK(!worlds.empty());
  std::vector<Named<const WorldBinding*>> names;
  for (const WorldBinding& world : worlds)
    names.push_back({world.name, &world});
  const WorldBinding* chosen = nullptr;
  sections.world.required_choice("name", chosen, std::span<const Named<const WorldBinding*>>(names),
                                 "the world to simulate");
  bind_sampler(sections.sampler, request.sampler);
  bind_stop(sections.stop, request.stop);
  bind_output(sections.output, request.output);
  if (chosen == nullptr) return nullptr;
  request.world = chosen->name;
  chosen->bind(sections.world, sections.constraint, sections.sampler);
  return chosen;
}

bool is_command_line_option(std::string_view key) {
  static constexpr std::array<std::string_view, 22> k_options{
      "thread",      "threads",   "thread_count", "num_threads", "rank",       "ranks",
      "workers",     "processes", "cores",        "jobs",        "cache",      "cache_size",
      "cache_bytes", "cache_mb",  "simulator",    "broad_phase", "time_limit", "timeout",
      "fresh",       "resume",    "verbose",      "progress"};
  return std::find(k_options.begin(), k_options.end(), key) != k_options.end();
}

}  // namespace sleight::request
