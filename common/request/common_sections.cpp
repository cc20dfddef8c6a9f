#include "common/request/common_sections.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string_view>
#include <vector>

namespace sleight::request {
namespace {

static_assert(k_burn_in_rounds == 4 && k_lanes == 8 && k_particles == 64 &&
                  k_island_burn_in_rounds == 1 && k_solutions_asked_for == 5,
              "the help states these defaults");

/// Refuses keys that the method would silently ignore.
void refuse_other_methods_keys(Binder& sampler, Method method) {
  if (!sampler.valid("method")) return;
  if (method == Method::search) return;  // search is checked in settle_search
  const bool has_islands = method == Method::sequential;
  const bool is_plain = method == Method::metropolis_hastings || makes_islands(method);
  const bool burns_in = has_islands || (!is_plain && method != Method::parallel_tempering);
  const bool ascends = method == Method::annealed_importance;
  const bool has_steps = ascends || method == Method::tempered_transitions;
  const auto refuse = [&](std::string_view key, bool has, std::string_view methods) {
    if (has || !sampler.given(key)) return;
    sampler.error(key, fmt::format("requires method {}", methods));
  };
  constexpr std::string_view k_with_ladders =
      "\"parallel_tempering\", \"simulated_tempering\", \"tempered_transitions\" or "
      "\"annealed_importance\"";
  refuse("replicas", !is_plain, k_with_ladders);
  refuse("ladder_power", !is_plain, k_with_ladders);
  refuse("burn_in_rounds", burns_in,
         "\"simulated_tempering\", \"tempered_transitions\", \"annealed_importance\" or "
         "\"sequential\"");
  if (has_islands && sampler.given("anneal_scans"))
    sampler.error("anneal_scans", "not used by method \"sequential\"");
  refuse("particles", makes_islands(method), "\"sequential\" or \"splitting\"");
  refuse("tour_scans", has_islands, "\"sequential\"");
  refuse("start", method == Method::metropolis_hastings || method == Method::parallel_tempering,
         "\"metropolis_hastings\" or \"parallel_tempering\"");
  refuse("lanes", ascends, "\"annealed_importance\"");
  refuse("steps_per_level", has_steps, "\"tempered_transitions\" or \"annealed_importance\"");
}

/// Checks that a tempered transition does not exceed its limit of iterations. A transition visits
/// all temperatures twice.
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
                            "steps_per_level x iterations_per_scan); expected fewer than {}",
                            steps, levels, k_excursion_iterations_max));
}

void bind_what_some_methods_have(Binder& sampler, SamplerParameters& p) {
  sampler.optional_integer("anneal_scans", p.anneal_scans,
                           {.minimum = 1,
                            .maximum = 1000000,
                            .unit = "scans",
                            .help = "number of scans that anneal a chain from the prior to the "
                                    "target, before its first draw; default: 0"});
  sampler.optional_integer("burn_in_rounds", p.burn_in_rounds,
                           {.minimum = 1,
                            .maximum = 20,
                            .unit = "rounds",
                            .help = "number of burn-in rounds. simulated_tempering, "
                                    "tempered_transitions and annealed_importance use them to "
                                    "choose temperatures (default: 4); sequential discards them "
                                    "(default: 1)"});
  sampler.optional_integer("lanes", p.lanes,
                           {.minimum = 1,
                            .maximum = 1024,
                            .help = "number of parallel ascents per chain "
                                    "(annealed_importance); default: 8"});
  sampler.optional_integer("steps_per_level", p.steps_per_level,
                           {.minimum = 1,
                            .maximum = 1000,
                            .unit = "steps",
                            .help = "number of steps between two temperatures "
                                    "(tempered_transitions, annealed_importance); default: 1"});
  sampler.optional_integer("particles", p.particles,
                           {.minimum = 2,
                            .maximum = k_particles_max,
                            .help = "number of particles per island (sequential, splitting); "
                                    "default: 64"});
  sampler.optional_integer("tour_scans", p.tour_scans,
                           {.minimum = 2,
                            .maximum = 1000000,
                            .unit = "scans",
                            .help = "restart a chain after this number of scans, and use only "
                                    "the last scan before a restart as a draw (sequential); "
                                    "default: no restarts"});
  sampler.optional_integer(
      "relax_scans", p.relax_scans,
      {.minimum = 1,
       .maximum = k_relax_scans_max,
       .unit = "scans",
       .help = "length of the chain that relaxes each find (search); default: no relaxation"});
}

void bind_sampler(Binder& sampler, SamplerParameters& p) {
  static constexpr std::array k_methods{
      Named<Method>{"metropolis_hastings", Method::metropolis_hastings},
      Named<Method>{"parallel_tempering", Method::parallel_tempering},
      Named<Method>{"simulated_tempering", Method::simulated_tempering},
      Named<Method>{"tempered_transitions", Method::tempered_transitions},
      Named<Method>{"annealed_importance", Method::annealed_importance},
      Named<Method>{"sequential", Method::sequential},
      Named<Method>{"splitting", Method::splitting},
      Named<Method>{"search", Method::search}};
  sampler.choice("method", p.method, std::span<const Named<Method>>(k_methods), "sampling method");
  static constexpr std::array k_starts{Named<Start>{"prior", Start::prior},
                                       Named<Start>{"search", Start::search}};
  sampler.choice(
      "start", p.start, std::span<const Named<Start>>(k_starts),
      "initial states (metropolis_hastings, parallel_tempering): \"prior\" uses prior draws; "
      "\"search\" uses solutions that a search finds, and tests the burn-in");
  sampler.integer("chains", p.chains,
                  {.minimum = 1, .maximum = k_chains_max, .help = "number of independent chains"});
  sampler.optional_integer("replicas", p.replicas,
                           {.minimum = 2,
                            .maximum = k_replicas_max,
                            .help = "number of temperatures in a ladder; default: chosen from the "
                                    "ladder's communication barrier"});
  sampler.optional_integer(
      "ladder_power", p.ladder_power,
      {.minimum = 1,
       .maximum = k_ladder_power_max,
       .help = "exponent of a temperature ladder in the run's first round, which may be a burn-in "
               "round; default: 6. Inverse temperature i of n is (i / (n - 1))^ladder_power, where "
               "n is the value of replicas, or 12 if replicas is not set. Later rounds adapt the "
               "ladder"});
  sampler.integer("seed", p.seed,
                  {.minimum = 0,
                   .maximum = static_cast<std::int64_t>(k_seed_max),
                   .help = "random seed; the same seed gives the same bits"});
  sampler.integer(
      "iterations_per_scan", p.iterations_per_scan,
      {.minimum = 1, .maximum = 1000000, .unit = "proposals", .help = "proposals per scan"});
  sampler.integer("round_scans", p.round_scans,
                  {.minimum = 1,
                   .maximum = k_round_scans_max,
                   .unit = "scans",
                   .help = "length of the first round; each later round is twice as long"});
  bind_what_some_methods_have(sampler, p);
  refuse_other_methods_keys(sampler, p.method);
  check_excursions(sampler, p);
}

void bind_stop(Binder& stop, StopRule& p) {
  stop.optional_integer("scans", p.scans,
                        {.minimum = 1,
                         .maximum = static_cast<std::int64_t>(k_scans_max),
                         .unit = "scans",
                         .help = "stop after this number of scans of each chain, including "
                                 "annealing and burn-in"});
  stop.optional_integer("rounds", p.rounds,
                        {.minimum = 1,
                         .maximum = k_rounds_max,
                         .unit = "rounds",
                         .help = "stop after this number of rounds of each chain"});
  stop.optional_integer("independent_solutions", p.independent_solutions,
                        {.minimum = 1,
                         .maximum = k_independent_solutions_max,
                         .help = "stop after this number of solutions from different lineages; "
                                 "default: 5 if no stop rule is given"});
  stop.optional_number(
      "odds", p.odds,
      {.minimum = k_odds_min,
       .maximum = k_odds_max,
       .unit = "nats",
       .help = "stop when the standard error of log P(satisfied) falls to this value (sequential, "
               "splitting); 0.1 means 10% of P. Such a run computes islands but no chains"});
  stop.optional_integer("found", p.found,
                        {.minimum = 1,
                         .maximum = k_found_max,
                         .help = "stop a search after this number of finds; default: 5. With "
                                 "other stop rules, the search runs before the chains"});
  stop.optional_integer(
      "takes", p.takes,
      {.minimum = 1,
       .maximum = k_takes_max,
       .help = "stop after this number of takes; a take is a find that a chain has relaxed and "
               "that still satisfies the constraint; default: 5 if no stop rule and no sampler is "
               "given"});
}

void bind_output(Binder& output, OutputParameters& p) {
  output.integer("thin", p.thin,
                 {.minimum = 1,
                  .maximum = 1000000000,
                  .unit = "scans",
                  .help = "interval between stored states; 1: every scan, 10: every tenth scan"});
  output.integer("keep_max", p.keep_max,
                 {.minimum = 0,
                  .maximum = 1000000,
                  .unit = "animations",
                  .help = "maximum number of stored animations; default with [stop] odds: 20"});
  output.integer("keep_per_lineage", p.keep_per_lineage,
                 {.minimum = 0,
                  .maximum = 1000,
                  .unit = "animations",
                  .help = "maximum number of stored animations from one lineage"});
  output.number(
      "min_distance", p.min_distance,
      {.minimum = 0,
       .maximum = 1e6,
       .unit = "units of likeness",
       .help = "minimum distance between two stored animations; the world defines this distance"});
  output.integer("prior_draws", p.prior_draws,
                 {.minimum = 0,
                  .maximum = k_prior_draws,
                  .help = "number of prior draws, for comparison with the samples; default with "
                          "method \"search\" or if 'odds' is set: 100"});
}

/// Keys of the common sections that apply to a search.
constexpr std::array<std::string_view, 2> k_sampler_keys_of_search{"method", "seed"};
constexpr std::array<std::string_view, 4> k_sampler_keys_of_takes{"method", "seed", "relax_scans",
                                                                  "iterations_per_scan"};
constexpr std::array<std::string_view, 3> k_sampler_keys_of_odds{"method", "seed", "particles"};
constexpr std::array<std::string_view, 1> k_stop_keys_of_search{"found"};
constexpr std::array<std::string_view, 1> k_stop_keys_of_takes{"takes"};
constexpr std::array<std::string_view, 2> k_output_keys_of_search{"keep_max", "prior_draws"};

/// Forbids all of a section's first `first_keys` keys, except those in `keys`. A forbidden key is
/// an error if the file has it. The normalised text omits forbidden keys.
void keep_only(Binder& section, std::size_t first_keys, std::span<const std::string_view> keys,
               std::string_view why) {
  const std::vector<BoundKey> all = section.keys();
  for (const BoundKey& bound : std::span(all).first(first_keys)) {
    const std::string& key = bound.spec.key;
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
    if (section.given(key)) section.error(key, why);
    section.settle(key, "");
  }
}

void settle_few_prior_draws(Binder& output, OutputParameters& p) {
  if (output.given("prior_draws")) return;
  p.prior_draws = k_prior_draws_of_search;
  output.settle("prior_draws", fmt::format("{}", k_prior_draws_of_search));
}

/// Applies a search's rules. All keys are bound before. The first `common_keys` keys of [sampler]
/// are common to all worlds. The other keys belong to the world and apply to chains.
void settle_search(SectionBinders& sections, std::size_t common_keys, DirectionRequest& request) {
  const auto all = [](const Binder& section) { return section.keys().size(); };
  const bool relaxes = request.sampler.relax_scans.has_value();
  if (relaxes) {
    keep_only(sections.sampler, common_keys, k_sampler_keys_of_takes,
              "with relax_scans, method \"search\" does not use this key");
    keep_only(sections.stop, all(sections.stop), k_stop_keys_of_takes,
              "can't be combined with relax_scans; set 'takes' instead");
  } else {
    keep_only(sections.sampler, all(sections.sampler), k_sampler_keys_of_search,
              "a search without relax_scans runs no chains, so it does not use this key");
    keep_only(sections.stop, all(sections.stop), k_stop_keys_of_search,
              "a search without relax_scans does not use this key; set 'found' instead");
  }
  keep_only(sections.output, all(sections.output), k_output_keys_of_search,
            "not used by method \"search\", because it makes no draws");
  request.sampler.chains = 0;
  settle_few_prior_draws(sections.output, request.output);
}

/// Returns whether [sampler] has no key except perhaps the seed and `key`.
bool leaves_open_but(const Binder& sampler, std::string_view key) {
  const auto& keys = sampler.keys();
  return std::none_of(keys.begin(), keys.end(), [&](const BoundKey& bound) {
    return bound.spec.key != "seed" && bound.spec.key != key && sampler.given(bound.spec.key);
  });
}
bool leaves_sampler_open(const Binder& sampler) {
  return leaves_open_but(sampler, "");
}

WorldSections world_sections(SectionBinders& sections) {
  return {.world = sections.world, .constraint = sections.constraint, .sampler = sections.sampler};
}

void let_world_choose(SectionBinders& sections, DirectionRequest& request,
                      const WorldBinding& world) {
  WorldSections of_world = world_sections(sections);
  world.serve_best(of_world, request.sampler, request.stop, request.parameters);
}

/// Chooses a search if the request leaves everything open, or if it has no stop rules other than
/// finds or takes.
void settle_method(SectionBinders& sections, DirectionRequest& request, const WorldBinding& world) {
  const auto& rules = sections.stop.keys();
  const auto asks_for_more_than = [&](std::string_view one) {
    return std::any_of(rules.begin(), rules.end(), [&](const BoundKey& bound) {
      return bound.spec.key != one && sections.stop.given(bound.spec.key);
    });
  };
  const bool wants_finds = sections.stop.given("found") && !asks_for_more_than("found");
  const bool wants_takes = !asks_for_more_than("takes");
  if (!world.has_search || !leaves_sampler_open(sections.sampler)) return;
  if (!wants_finds && !(wants_takes && world.serve_best)) return;
  request.sampler.method = Method::search;
  sections.sampler.settle("method", "\"search\"");
  if (wants_finds) return;
  // The file may omit `takes`, or its value may be invalid.
  if (!request.stop.takes) {
    request.stop.takes = k_solutions_asked_for;
    sections.stop.settle("takes", fmt::format("{}", k_solutions_asked_for));
  }
  let_world_choose(sections, request, world);
  CHECK(request.sampler.relax_scans.has_value());
}

/// If the request leaves the sampler open, lets the world choose it. The run then shows finds
/// before it makes draws.
void settle_default(SectionBinders& sections, DirectionRequest& request,
                    const WorldBinding& world) {
  if (request.sampler.method == Method::search) return;
  // If a request for odds names the method, the sampler still counts as open: a world has only one
  // method that estimates odds.
  const bool names_islands = request.stop.odds && makes_islands(request.sampler.method);
  if (!leaves_open_but(sections.sampler, names_islands ? "method" : "") || !world.serve_best)
    return;
  let_world_choose(sections, request, world);
  if (request.stop.found || !request.stop.independent_solutions) return;
  request.stop.found = request.stop.independent_solutions;
  sections.stop.settle("found", fmt::format("{}", *request.stop.found));
}

void settle_stop(SectionBinders& sections, DirectionRequest& request) {
  const bool searches = request.sampler.method == Method::search;
  const bool relaxes = request.sampler.relax_scans.has_value();
  Binder& stop = sections.stop;
  const auto given = [&](const char* key) { return stop.given(key); };
  const bool some = relaxes    ? request.stop.takes.has_value()
                    : searches ? given("found")
                               : given("scans") || given("rounds") ||
                                     given("independent_solutions") || given("odds");
  if (some) return;
  const char* key = relaxes ? "takes" : searches ? "found" : "independent_solutions";
  (relaxes    ? request.stop.takes
   : searches ? request.stop.found
              : request.stop.independent_solutions) = k_solutions_asked_for;
  stop.settle(key, fmt::format("{}", k_solutions_asked_for));
}

/// Checks that a request has both or neither of `takes` and `relax_scans`. A take is a find that a
/// chain has relaxed.
void check_takes(SectionBinders& sections, const DirectionRequest& request) {
  const bool searches = request.sampler.method == Method::search;
  if (request.sampler.relax_scans && !searches && sections.sampler.valid("method"))
    sections.sampler.error("relax_scans", "requires method \"search\"");
  if (sections.stop.given("takes") && !request.sampler.relax_scans) {
    sections.stop.error(
        "takes",
        "requires method \"search\" and relax_scans, or a [sampler] section with no key but "
        "'seed'; [stop] can have no other rule");
  }
}

/// Applies the rules for odds. Islands estimate P(satisfied) while they run, and their error can be
/// planned. No other method does this. A run with the rule `odds` makes only islands.
void settle_odds(SectionBinders& sections, DirectionRequest& request) {
  const Method method = request.sampler.method;
  if (!sections.sampler.valid("method")) return;
  if (method == Method::search) return;  // has no stop rules for odds
  if (method == Method::splitting && !sections.stop.given("odds")) {
    sections.sampler.error(
        "method", "\"splitting\" estimates only the odds; it requires 'odds' under [stop]");
  }
  if (!sections.stop.given("odds") || !sections.stop.valid("odds")) return;
  if (!makes_islands(method)) {
    return sections.stop.error("odds",
                               "requires method \"sequential\" or \"splitting\", whose islands "
                               "estimate the odds");
  }
  for (const char* rule : {"rounds", "independent_solutions"}) {
    if (sections.stop.given(rule))
      sections.stop.error(
          rule,
          "can't be combined with 'odds', because a run with 'odds' makes no draws; a run with "
          "independent_solutions also estimates the odds, from its islands");
  }
  keep_only(sections.sampler, sections.sampler.keys().size(), k_sampler_keys_of_odds,
            "not used with [stop] odds, because such a run computes islands instead of chains");
  request.sampler.chains = 1;
  request.sampler.tour_scans.reset();
  request.sampler.burn_in_rounds = 0;
  settle_few_prior_draws(sections.output, request.output);
  if (sections.output.given("keep_max")) return;
  request.output.keep_max = k_keep_max_of_odds;
  sections.output.settle("keep_max", fmt::format("{}", k_keep_max_of_odds));
}

/// Checks requests whose chains start at finds. A plain chain's burn-in is judged in separate
/// rounds, by comparing all chains. A ladder's burn-in is judged by the origin of its lineages.
void check_start(SectionBinders& sections, const DirectionRequest& request) {
  const SamplerParameters& p = request.sampler;
  if (p.start == Start::prior) return sections.sampler.settle("start", "");
  if (p.anneal_scans)
    sections.sampler.error("anneal_scans", "can't be combined with start = \"search\"");
  if (p.method == Method::parallel_tempering) return;
  constexpr std::uint32_t k_chains_judged_min = 2;
  constexpr std::uint32_t k_judged_round_min = 4;
  const std::string why = "start = \"search\"";
  if (sections.sampler.valid("chains") && p.chains < k_chains_judged_min) {
    sections.sampler.error("chains", fmt::format("must be at least {}, because the burn-in "
                                                 "test with {} compares chains",
                                                 k_chains_judged_min, why));
  }
  if (sections.sampler.valid("round_scans") && p.round_scans < k_judged_round_min) {
    sections.sampler.error("round_scans",
                           fmt::format("must be at least {} with {}", k_judged_round_min, why));
  }
  if (request.stop.rounds) {
    sections.stop.error("rounds", fmt::format("can't be combined with {}, whose burn-in has no "
                                              "fixed length; use independent_solutions instead",
                                              why));
  }
}

/// Checks the keys of a request with tours. A tour has its own burn-in and no rounds.
void check_tours(SectionBinders& sections, const DirectionRequest& request) {
  if (!request.sampler.tour_scans || !sections.sampler.valid("tour_scans")) return;
  if (sections.sampler.given("burn_in_rounds"))
    sections.sampler.error(
        "burn_in_rounds",
        "can't be combined with tour_scans; in a tour, all scans except the last are burn-in");
  if (sections.stop.given("rounds") && sections.stop.valid("rounds"))
    sections.stop.error("rounds",
                        "can't be combined with tour_scans; use scans or independent_solutions "
                        "instead");
}

/// If the request uses islands or a search, checks that the world has them.
void check_stages(SectionBinders& sections, const DirectionRequest& request,
                  const WorldBinding& world, std::span<const WorldBinding> worlds) {
  const Method method = request.sampler.method;
  const auto why_not = [&](std::string_view what, bool WorldBinding::*has) {
    std::vector<std::string_view> names;
    for (const WorldBinding& other : worlds)
      if (other.*has) names.push_back(other.name);
    const std::string which = names.empty() ? "" : fmt::format(" ({})", fmt::join(names, ", "));
    return fmt::format("requires a world with {}{}; the world {} has none", what, which,
                       world.name);
  };
  if (method == Method::sequential && !world.has_islands && sections.sampler.valid("method"))
    sections.sampler.error("method", why_not("islands", &WorldBinding::has_islands));
  if (method == Method::splitting && !world.has_splitting && sections.sampler.valid("method"))
    sections.sampler.error("method", why_not("stages to split at", &WorldBinding::has_splitting));
  if (world.has_search || makes_islands(method)) return;
  const std::string why = why_not("a search", &WorldBinding::has_search);
  if (sections.sampler.valid("method") && method == Method::search) {
    sections.sampler.error("method", why);
  } else if (sections.sampler.valid("start") && request.sampler.start == Start::search) {
    sections.sampler.error("start", why);
  } else if (sections.stop.given("found")) {
    sections.stop.error("found", why);
  } else if (sections.stop.given("takes")) {
    sections.stop.error("takes", why);
  }
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
                                 "world to simulate");
  bind_sampler(sections.sampler, request.sampler);
  const std::size_t common_keys = sections.sampler.keys().size();
  bind_stop(sections.stop, request.stop);
  bind_output(sections.output, request.output);
  if (chosen == nullptr) return nullptr;
  request.world = chosen->name;
  WorldSections of_world = world_sections(sections);
  request.parameters = chosen->bind(of_world);
  settle_method(sections, request, *chosen);
  check_stages(sections, request, *chosen, worlds);
  check_takes(sections, request);
  if (request.sampler.method == Method::search) settle_search(sections, common_keys, request);
  check_start(sections, request);
  settle_stop(sections, request);
  settle_default(sections, request, *chosen);
  settle_odds(sections, request);
  check_tours(sections, request);
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
