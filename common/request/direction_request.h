// A direction request: a TOML file that describes a run.
//
//   [world]       the world, and its model's parameters
//   [constraint]  the required outcome of its animations
//   [sampler]     how animations are drawn: method, chains, seed, and the world's proposals
//   [stop]        stop rules: the first that holds ends the run
//   [output]      what the archive stores
//
// A section may have tables, such as [world.noise], and arrays of tables, such as [[world.die]].
// Each table has keys of its own, and may have tables again: [[world.die.mark]].
//
// Each world binds its own keys in [world] and [constraint], and the keys of its proposals in
// [sampler]. This module accesses a world only through a WorldBinding; a program's main passes the
// available worlds.
//
// Invariants
//   1. A key exists only if it may change results. Settings that can't change results (ranks,
//      threads, cache, simulator) are command-line options. Using such an option as a key is an
//      error that names the option.
//   2. All errors of a file are reported, ordered by place. A file that is not TOML has one error.
//   3. normalised_text is canonical: every key with its value, in a fixed order. Reading this text
//      gives an equal request, and that request has the same text. The text depends only on values,
//      not on the file's notation, comments or order.
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
  splitting,   ///< islands within nested levels, for worlds that judge in stages; only the odds
  search       ///< builds solutions, but not in proportion; for worlds that have a search
};

inline bool makes_islands(Method method) {
  return method == Method::sequential || method == Method::splitting;
}

/// Initial states of metropolis_hastings chains.
enum class Start {
  prior,  ///< a draw from the prior
  search  ///< a find of a search; its burn-in is tested (worker/sampling/judged_chains.h)
};

struct SamplerParameters {
  Method method = Method::parallel_tempering;
  /// Number of independent chains. With tempering: number of ladders. 0: a search without chains.
  std::uint32_t chains = 4;
  std::optional<std::uint32_t> replicas{};  ///< per ladder; empty: chosen by the ladder's barrier
  /// Exponent in the formula for a first ladder's inverse temperatures: (i / (replicas -
  /// 1))^ladder_power. Empty: 6.
  std::optional<std::uint32_t> ladder_power{};
  std::uint64_t seed = 1;                 ///< of all random numbers; at most k_seed_max
  std::uint32_t iterations_per_scan = 1;  ///< proposals between two recorded states
  std::uint32_t round_scans = 64;         ///< round r, from 1, has round_scans * 2^(r-1) scans
  /// Scans of simulated annealing at the start. Empty: 0.
  std::optional<std::uint32_t> anneal_scans{};
  /// Number of rounds before the draws. simulated_tempering, tempered_transitions and
  /// annealed_importance find their temperatures in these rounds, by parallel tempering. Empty:
  /// k_burn_in_rounds. For sequential, these rounds are the burn-in. Empty:
  /// k_island_burn_in_rounds.
  std::optional<std::uint32_t> burn_in_rounds{};
  /// For annealed_importance: number of parallel ascents. Empty: k_lanes.
  std::optional<std::uint32_t> lanes{};
  /// For annealed_importance and tempered_transitions: steps between neighbouring temperatures.
  /// Empty: 1.
  std::optional<std::uint32_t> steps_per_level{};
  /// For sequential and splitting: particles per island. Empty: k_particles.
  std::optional<std::uint32_t> particles{};
  /// For sequential: number of scans after which a chain restarts. Only the last scan before a
  /// restart is a draw. Empty: no restarts.
  std::optional<std::uint32_t> tour_scans{};
  Start start = Start::prior;
  /// For a search: number of scans of the chain that relaxes a find
  /// (worker/sampling/relaxed_finds.h). Empty: finds aren't relaxed.
  std::optional<std::uint32_t> relax_scans{};
  friend bool operator==(const SamplerParameters&, const SamplerParameters&) = default;
};

/// Returns how many of a chain's scans don't count: those of annealing and burn-in.
std::uint64_t scans_before_draws(const SamplerParameters& sampler);

/// Stop rules. A request has at least one rule, given or by default (k_solutions_asked_for). Rules
/// depend on logical counts, never on a clock. n rounds together have round_scans * (2^n - 1)
/// scans. The scans of all rounds must not exceed k_scans_max either.
struct StopRule {
  /// Scans per chain, including its start (scan 0). More than scans_before_draws.
  std::optional<std::uint64_t> scans;
  std::optional<std::uint32_t> rounds;  ///< per chain
  /// Number of lineages, in all chains together, in which an animation satisfies the constraint.
  /// Lineages are counted at the ends of rounds.
  std::optional<std::uint32_t> independent_solutions;
  /// A search ends when it has this number of finds. If the world has a search, such a search may
  /// also precede the chains.
  std::optional<std::uint32_t> found{};
  /// For sequential and splitting: free islands estimate log P(satisfied), and this is the
  /// estimate's required standard error, in nats. A run with `odds` makes only islands; `scans`
  /// limits their number (worker/sampling/odds_rule.h).
  std::optional<double> odds{};
  /// Number of takes: finds of a search, each relaxed by a separate chain. Excludes other rules.
  std::optional<std::uint32_t> takes{};
  friend bool operator==(const StopRule&, const StopRule&) = default;
};

struct WorldSections {
  Binder& world;
  Binder& constraint;
  Binder& sampler;
};

/// The interface of a world to requests. The type of the parameters is known only to the world.
/// bind_world makes a binding from functions that use this type.
struct WorldBinding {
  std::string name;     ///< value of `name` in [world]
  std::string summary;  ///< one line for help
  /// Binds the world's keys and returns the parameters with the request's values.
  std::function<std::any(WorldSections& sections)> bind;
  bool has_search = false;     ///< worker/sampling/stage_search.h
  bool has_islands = false;    ///< worker/sampling/stages.h
  bool has_splitting = false;  ///< worker/sampling/splitting.h
  /// Called if the request has no key of [sampler] except perhaps the seed. Chooses the sampler:
  /// sets the parameters and settles their keys. The choice may depend on which stop rules are
  /// given. The choice must not depend on the rules' numbers, so that a longer run can resume a
  /// shorter one. Empty: every key has its own default.
  std::function<void(WorldSections& sections, SamplerParameters& sampler, const StopRule& stop,
                     std::any& parameters)>
      serve_best{};
};

/// Returns a binding whose `bind` fills a default-constructed Parameters.
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

/// Like bind_world above, but for a world that has a search and islands, and chooses its sampler.
template <class Parameters>
WorldBinding bind_world(std::string name, std::string summary,
                        void (*bind)(WorldSections& sections, Parameters& parameters),
                        void (*serve_best)(WorldSections& sections, SamplerParameters& sampler,
                                           const StopRule& stop, Parameters& parameters)) {
  WorldBinding binding = bind_world(std::move(name), std::move(summary), bind);
  binding.has_search = true;
  binding.has_islands = true;
  binding.serve_best = [serve_best](WorldSections& sections, SamplerParameters& sampler,
                                    const StopRule& stop, std::any& parameters) {
    serve_best(sections, sampler, stop, std::any_cast<Parameters&>(parameters));
  };
  return binding;
}

/// Default for runs of chains. A search or an estimate of odds needs fewer prior draws.
inline constexpr std::uint32_t k_prior_draws = 1000;
inline constexpr std::uint32_t k_prior_draws_of_search = 100;

/// Default for runs that estimate odds: just enough animations to look at.
inline constexpr std::uint32_t k_keep_max_of_odds = 20;

struct OutputParameters {
  std::uint32_t thin = 1;              ///< store the states of every thin-th scan
  std::uint32_t keep_max = 5000;       ///< maximum kept animations; 0: none
  std::uint32_t keep_per_lineage = 3;  ///< maximum kept animations per lineage
  double min_distance = 0.5;  ///< between kept animations, in the world's likeness distance
  std::uint32_t prior_draws = k_prior_draws;  ///< draws from the prior for comparison
  friend bool operator==(const OutputParameters&, const OutputParameters&) = default;
};

/// A section's keys, in their fixed order. Each value is TOML. Each table counts as a section. It
/// follows the section or table that it is in.
struct NormalisedSection {
  /// Text between the brackets: "world", "world.noise" for a table, or "[world.die]" for a table of
  /// an array.
  std::string name;
  std::vector<std::pair<std::string, std::string>> keys;
  friend bool operator==(const NormalisedSection&, const NormalisedSection&) = default;
};

struct DirectionRequest {
  std::string world;  ///< name of the WorldBinding
  SamplerParameters sampler;
  StopRule stop;
  OutputParameters output;
  std::vector<NormalisedSection>
      sections;         ///< all five sections and their tables, including the world's
  std::any parameters;  ///< the world's own, see parameters_of

  /// Doesn't compare `parameters`, which has no comparison operator: `sections` has the same
  /// values.
  friend bool operator==(const DirectionRequest& a, const DirectionRequest& b) {
    return a.world == b.world && a.sampler == b.sampler && a.stop == b.stop &&
           a.output == b.output && a.sections == b.sections;
  }
};

/// REQUIRES: `Parameters` is the parameter type of the request's world.
template <class Parameters>
const Parameters& parameters_of(const DirectionRequest& request) {
  const auto* parameters = std::any_cast<Parameters>(&request.parameters);
  CHECK(parameters != nullptr);
  return *parameters;
}

/// Maximum size of a request's normalised text. Other rules of [stop] may lengthen it a little, but
/// it stays readable (k_request_bytes_max).
inline constexpr std::size_t k_normalised_bytes_max = k_request_bytes_max - 4096;
inline constexpr std::uint32_t k_chains_max = 65536;
inline constexpr std::uint32_t k_replicas_max = 256;
inline constexpr std::uint32_t k_ladder_power_max = 12;
/// Maximum number of temperatures, if the ladder's barrier determines the number.
inline constexpr std::uint32_t k_chosen_replicas_max = 64;
/// A tempered transition has fewer iterations than this.
inline constexpr std::uint64_t k_excursion_iterations_max = std::uint64_t{1} << 20U;
inline constexpr std::uint32_t k_burn_in_rounds = 4;
inline constexpr std::uint32_t k_lanes = 8;
inline constexpr std::uint64_t k_seed_max = 9223372036854775807U;  // maximum of TOML integers
inline constexpr std::uint64_t k_scans_max = 1000000000000U;
inline constexpr std::uint32_t k_rounds_max = 40;
inline constexpr std::uint32_t k_round_scans_max = 1000000;
inline constexpr std::uint32_t k_independent_solutions_max = 1000000;
inline constexpr std::uint32_t k_found_max = 1000000;
/// Takes are limited, because every find needs a separate chain, even if the find does not become a
/// take.
inline constexpr std::uint32_t k_takes_max = 10000;
inline constexpr std::uint32_t k_relax_scans_max = 1000000;
/// In nats. The number of islands is proportional to 1 / error^2. With an error above 1, the odds
/// would be uncertain by more than a factor of 2.7 in either direction.
inline constexpr double k_odds_min = 0.001;
inline constexpr double k_odds_max = 1;
/// Default number of takes, independent solutions or finds, if no rule is given.
inline constexpr std::uint32_t k_solutions_asked_for = 5;
inline constexpr std::uint32_t k_particles = 64;
inline constexpr std::uint32_t k_particles_max = 4096;
inline constexpr std::uint32_t k_island_burn_in_rounds = 1;

/// The kinds of answers that a run may look for if its request leaves the sampler open.
enum class Answer : std::uint8_t {
  takes,         ///< relaxed finds of a search
  found,         ///< unrelaxed finds of a search
  in_proportion  ///< independent solutions
};

/// Goals from the command line that replace a request's [stop].
struct Asked {
  /// Kind of answer. Empty: the kind that [stop] requests (finds, takes or independent solutions).
  /// If [stop] requests no kind: takes if the sampler is left open, finds if the method is a
  /// search, otherwise independent solutions.
  std::optional<Answer> answer{};
  std::uint32_t number = k_solutions_asked_for;
};

/// Reads a request. `file` appears in errors, but is not opened. REQUIRES: `worlds` is not empty
/// and has distinct names; asked->number is from 1 to k_independent_solutions_max.
base::Result<DirectionRequest, std::vector<Diagnostic>> read_request(
    std::string_view text, std::string_view file, std::span<const WorldBinding> worlds,
    std::optional<Asked> asked = {});

/// Returns the whole request in canonical form. If one of the request's own rules ended the run,
/// the archive stores this text.
std::string normalised_text(const DirectionRequest& request);

/// The place in a run at which an archive's results end. If finds are relaxed, the archive contains
/// takes. As long as there is no take, the archive contains finds.
struct Cut {
  std::uint64_t scans = 0;
  std::uint64_t found = 0;
  std::uint64_t relaxed = 0;
  std::uint64_t prior_draws = 0;
};

/// Returns normalised_text with [stop] and prior_draws set to `cut`: the request that reproduces
/// the archive exactly. If there are neither scans nor takes, the text describes a search. If there
/// are islands, the text also retains the rules `odds` and `independent_solutions`, because the
/// islands' results decide when these rules hold. An archive needs the rules to decide whether its
/// islands count. If such a rule ended the original run before the cut, it ends the reproduced run
/// at the same scan. REQUIRES: scans, found or relaxed is not 0; scans <= k_scans_max, found <=
/// k_found_max.
std::string normalised_text_of(const DirectionRequest& request, const Cut& cut);

/// Returns [world], [constraint] and [sampler] of the normalised text. Requests with equal text
/// have the same chains, so each can resume the other's run.
std::string identity_text(const DirectionRequest& request);

/// Returns the request with another seed, as if the request's file had that seed. REQUIRES: seed <=
/// k_seed_max.
DirectionRequest with_seed(DirectionRequest request, std::uint64_t seed);

/// Returns a request for the search alone, without the chains that follow it. The search alone has
/// the same finds as before the chains. REQUIRES: stop.found or stop.takes.
DirectionRequest search_of(DirectionRequest request);

struct SectionKeys {
  std::string name;  ///< as in NormalisedSection
  std::vector<KeySpec> keys;
};

/// Returns every key of a request for this world.
std::vector<SectionKeys> request_keys(const WorldBinding& world);

/// Formats request_keys as an aligned table: key, unit, range, default, help.
std::string key_table(const WorldBinding& world);

}  // namespace sleight::request
