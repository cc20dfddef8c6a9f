// A direction request: what a person asks for, as a TOML file.
//
//   [world]       which world, and its model's numbers
//   [constraint]  where its animations shall end
//   [sampler]     how animations are drawn: method, chains, seed, and the world's proposals
//   [stop]        when it is enough: the first of the given rules that holds ends the run
//   [output]      what is kept
//
// A section may have arrays of tables, as [[world.die]], each table with keys of its own.
//
// The keys of a world (in [world], [constraint] and, for its proposals, [sampler]) are bound by the
// world itself, which this module knows as a WorldBinding only; a program's main passes the worlds
// that it has.
//
// Invariants
//   1. A key is here because it may change results; what may not (ranks, threads, cache,
//      simulator) is an option of the command line, and as a key it is an error that says so.
//   2. Every error of a file is reported, in the order of places; a file that is not TOML has one.
//   3. normalised_text is canonical: every key with its value, in a fixed order; reading it again
//      gives an equal request and the same text. It depends on values alone, not on how the file
//      wrote them, nor on its comments and order.
// Values; thread-safe as such.
#pragma once

#include <any>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "common/base/result.h"
#include "common/request/binder.h"
#include "common/request/diagnostic.h"

namespace sleight::request {

enum class Method {
  metropolis_hastings,
  parallel_tempering,
  simulated_tempering,
  tempered_transitions,
  annealed_importance,
  sequential,  ///< islands of particles, for worlds that act in stages
  search       ///< builds solutions, draws none in proportion; for worlds that act in stages
};

/// Where chains of metropolis_hastings start.
enum class Start {
  prior,  ///< a draw from it
  search  ///< a find of a search: then burn-ins are judged (worker/sampling/judged_chains.h)
};

struct SamplerParameters {
  Method method = Method::parallel_tempering;
  /// Independent of each other; ladders, where tempered; 0 where a search is all.
  std::uint32_t chains = 4;
  std::optional<std::uint32_t> replicas{};  ///< of a ladder; none: as many as its barrier asks for
  /// Of a first ladder, whose inverse temperatures are (i / (replicas - 1)) to it; none: 6.
  std::optional<std::uint32_t> ladder_power{};
  std::uint64_t seed = 1;                 ///< of all random draws; at most k_seed_max
  std::uint32_t iterations_per_scan = 1;  ///< proposals between two recorded states
  std::uint32_t round_scans = 64;         ///< round r, from 1, has round_scans * 2^(r-1) scans
  /// Of simulated annealing, before all else; none: 0.
  std::optional<std::uint32_t> anneal_scans{};
  /// Of parallel tempering, by which simulated_tempering, tempered_transitions and
  /// annealed_importance find their temperatures: none: k_burn_in_rounds. Of sequential, that
  /// don't count; none: k_island_burn_in_rounds.
  std::optional<std::uint32_t> burn_in_rounds{};
  /// Of annealed_importance: ascents beside each other; none: k_lanes.
  std::optional<std::uint32_t> lanes{};
  /// Of it and of tempered_transitions: from one temperature to the next; none: 1.
  std::optional<std::uint32_t> steps_per_level{};
  /// Of an island of sequential; none: k_particles.
  std::optional<std::uint32_t> particles{};
  /// Of sequential: a chain starts anew after so many scans, of which the last one alone is a draw;
  /// none: it never does.
  std::optional<std::uint32_t> tour_scans{};
  Start start = Start::prior;
  /// Of a search whose finds are relaxed: so many scans of a chain each; none: they are left as
  /// they are (worker/sampling/relaxed_finds.h).
  std::optional<std::uint32_t> relax_scans{};
  friend bool operator==(const SamplerParameters&, const SamplerParameters&) = default;
};

/// Scans of each chain before those whose states count: of annealing, and of a burn-in.
std::uint64_t scans_before_draws(const SamplerParameters& sampler);

/// One is given, or follows (k_solutions_asked_for). Each is judged logically, never by a clock.
/// The scans of `rounds` rounds, round_scans * (2^rounds - 1), are at most k_scans_max too.
struct StopRule {
  /// Of each chain, its start (scan 0) included; more than scans_before_draws.
  std::optional<std::uint64_t> scans;
  std::optional<std::uint32_t> rounds;  ///< of each chain
  /// Lineages with a satisfying animation, over all chains, judged at the ends of rounds.
  std::optional<std::uint32_t> independent_solutions;
  /// A search's rule; chains of a world that acts in stages may have a search before them, which
  /// ends then.
  std::optional<std::uint32_t> found{};
  /// Standard error of log P(satisfied), in nats, that free islands are to know it to: of
  /// sequential. Nothing else is made then; `scans` counts islands, and bounds them
  /// (worker/sampling/odds_rule.h).
  std::optional<double> odds{};
  /// Finds of a search, each relaxed by a chain of its own: goes alone.
  std::optional<std::uint32_t> takes{};
  friend bool operator==(const StopRule&, const StopRule&) = default;
};

/// The sections that have keys of the world's.
struct WorldSections {
  Binder& world;
  Binder& constraint;
  Binder& sampler;
};

/// A world as a request sees it. Its parameters are of a type that only the world knows; bind_world
/// makes a binding from functions that name the type.
struct WorldBinding {
  std::string name;     ///< of `name` in [world]
  std::string summary;  ///< one line for help
  /// Returns the world's parameters, bound to its keys: they have the request's values.
  std::function<std::any(WorldSections& sections)> bind;
  /// It can be searched, and sampled by islands (worker/sampling/stages.h).
  bool acts_in_stages = false;
  /// Chooses the sampler where a request leaves it open (a seed aside): sets parameters and settles
  /// their keys. The choice may depend on which stop rules are given, but not on their numbers, so
  /// that a longer run continues a shorter one. None: every key has its own default.
  std::function<void(WorldSections& sections, SamplerParameters& sampler, const StopRule& stop,
                     std::any& parameters)>
      serve_best{};
};

/// A binding whose `bind` fills a default-constructed Parameters.
template <class Parameters>
WorldBinding bind_world(std::string name, std::string summary,
                        void (*bind)(WorldSections& sections, Parameters& parameters)) {
  return {.name = std::move(name),
          .summary = std::move(summary),
          .bind = [bind](WorldSections& sections) -> std::any {
            Parameters parameters;
            bind(sections, parameters);
            return parameters;
          }};
}

/// The same for a world that acts in stages and chooses its sampler.
template <class Parameters>
WorldBinding bind_world(std::string name, std::string summary,
                        void (*bind)(WorldSections& sections, Parameters& parameters),
                        void (*serve_best)(WorldSections& sections, SamplerParameters& sampler,
                                           const StopRule& stop, Parameters& parameters)) {
  WorldBinding binding = bind_world(std::move(name), std::move(summary), bind);
  binding.acts_in_stages = true;
  binding.serve_best = [serve_best](WorldSections& sections, SamplerParameters& sampler,
                                    const StopRule& stop, std::any& parameters) {
    serve_best(sections, sampler, stop, std::any_cast<Parameters&>(parameters));
  };
  return binding;
}

/// Of a run of chains; a search, or the odds, show enough beside fewer.
inline constexpr std::uint32_t k_prior_draws = 1000;
inline constexpr std::uint32_t k_prior_draws_of_search = 100;

/// Of a run that asks for the odds: something to look at.
inline constexpr std::uint32_t k_keep_max_of_odds = 20;

struct OutputParameters {
  std::uint32_t thin = 1;              ///< every thin-th scan's state is kept
  std::uint32_t keep_max = 5000;       ///< satisfying animations that are kept; 0 keeps none
  std::uint32_t keep_per_lineage = 3;  ///< of these, from one lineage
  double min_distance = 0.5;           ///< of two that are kept, in the world's likeness distance
  std::uint32_t prior_draws = k_prior_draws;  ///< to compare samples with
  friend bool operator==(const OutputParameters&, const OutputParameters&) = default;
};

/// A section's keys in their fixed order, each value as TOML. A table of an array is one as well.
struct NormalisedSection {
  std::string name;  ///< what stands between the brackets: "world", and "[world.die]" of a table
  std::vector<std::pair<std::string, std::string>> keys;
  friend bool operator==(const NormalisedSection&, const NormalisedSection&) = default;
};

struct DirectionRequest {
  std::string world;  ///< the name of its WorldBinding
  SamplerParameters sampler;
  StopRule stop;
  OutputParameters output;
  std::vector<NormalisedSection> sections;  ///< all five and their tables, the world's included
  std::any parameters;                      ///< the world's own: parameters_of

  /// `parameters` has no comparison and needs none: `sections` has the same values.
  friend bool operator==(const DirectionRequest& a, const DirectionRequest& b) {
    return a.world == b.world && a.sampler == b.sampler && a.stop == b.stop &&
           a.output == b.output && a.sections == b.sections;
  }
};

/// The parameters of the request's world. REQUIRES: Parameters is that world's type.
template <class Parameters>
const Parameters& parameters_of(const DirectionRequest& request) {
  const auto* parameters = std::any_cast<Parameters>(&request.parameters);
  CHECK(parameters != nullptr);
  return *parameters;
}

inline constexpr std::uint32_t k_chains_max = 65536;
inline constexpr std::uint32_t k_replicas_max = 256;
inline constexpr std::uint32_t k_ladder_power_max = 12;
/// Temperatures that are chosen from the barrier, at most.
inline constexpr std::uint32_t k_chosen_replicas_max = 64;
/// Of one tempered transition, fewer.
inline constexpr std::uint64_t k_excursion_iterations_max = std::uint64_t{1} << 20U;
inline constexpr std::uint32_t k_burn_in_rounds = 4;
inline constexpr std::uint32_t k_lanes = 8;
inline constexpr std::uint64_t k_seed_max = 9223372036854775807U;  // TOML integers end there
inline constexpr std::uint64_t k_scans_max = 1000000000000U;
inline constexpr std::uint32_t k_rounds_max = 40;
inline constexpr std::uint32_t k_round_scans_max = 1000000;
inline constexpr std::uint32_t k_independent_solutions_max = 1000000;
inline constexpr std::uint32_t k_found_max = 1000000;
/// Each has a chain of its own, and so has each find that does not become one.
inline constexpr std::uint32_t k_takes_max = 10000;
inline constexpr std::uint32_t k_relax_scans_max = 1000000;
/// Nats: the islands that it takes grow with the inverse square, and above 1 the odds are open by a
/// factor of 2.7 to either side.
inline constexpr double k_odds_min = 0.001;
inline constexpr double k_odds_max = 1;
/// Where no rule is given: takes, independent solutions, or finds.
inline constexpr std::uint32_t k_solutions_asked_for = 5;
inline constexpr std::uint32_t k_particles = 64;
inline constexpr std::uint32_t k_particles_max = 4096;
inline constexpr std::uint32_t k_island_burn_in_rounds = 1;

/// What a request that leaves the sampler open can be answered with.
enum class Answer : std::uint8_t {
  takes,         ///< finds of a search, relaxed
  found,         ///< finds as they are
  in_proportion  ///< independent solutions
};

/// What a command line asks for in the place of a request's [stop].
struct Asked {
  /// None: what [stop] asks for, finds or takes or independent solutions; where it asks for
  /// nothing, takes if the sampler is left open, else independent solutions, of a search finds.
  std::optional<Answer> answer{};
  std::uint32_t number = k_solutions_asked_for;
};

/// Reads a request. `file` is named in the errors and not opened.
/// REQUIRES: worlds is not empty, its names are distinct; asked->number at least 1, at most
/// k_independent_solutions_max.
base::Result<DirectionRequest, std::vector<Diagnostic>> read_request(
    std::string_view text, std::string_view file, std::span<const WorldBinding> worlds,
    std::optional<Asked> asked = {});

/// The whole request, canonically: what an archive stores of a run that ended by its own rule.
std::string normalised_text(const DirectionRequest& request);

/// Where an archive is cut. If a search's finds are relaxed, the archive has its takes, or its
/// finds before the first take.
struct Cut {
  std::uint64_t scans = 0;
  std::uint64_t found = 0;
  std::uint64_t relaxed = 0;
  std::uint64_t prior_draws = 0;
};

/// As normalised_text with these for [stop] and prior_draws: the request that reproduces exactly
/// what an archive holds. Without scans and takes it is the search alone. Beside the scans of
/// islands it keeps the rules that end a run by what islands say, odds and independent_solutions:
/// by them an archive tells whether it may count its islands, and the run that they ended before
/// ends there again. REQUIRES: scans, found or relaxed is not 0; scans
/// <= k_scans_max, found <= k_found_max.
std::string normalised_text_of(const DirectionRequest& request, const Cut& cut);

/// [world], [constraint] and [sampler] of the normalised text. Requests for which it is equal walk
/// the same chains, so the run of one may be continued for the other.
std::string identity_text(const DirectionRequest& request);

/// The request with another seed, as if its file had it. REQUIRES: seed <= k_seed_max.
DirectionRequest with_seed(DirectionRequest request, std::uint64_t seed);

/// The search that comes before a request's chains, as a request of its own: it finds the same.
/// REQUIRES: stop.found or stop.takes.
DirectionRequest search_of(DirectionRequest request);

/// A section, or any table of an array, and what its keys are.
struct SectionKeys {
  std::string name;
  std::vector<KeySpec> keys;
};

/// Every key of a request for this world.
std::vector<SectionKeys> request_keys(const WorldBinding& world);

/// request_keys as an aligned table for a terminal: key, unit, range, default, help.
std::string key_table(const WorldBinding& world);

}  // namespace sleight::request
