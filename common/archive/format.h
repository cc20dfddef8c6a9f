// Names, version and limits of the sample archive. docs/ARCHIVE_FORMAT.md defines their meaning.
//
// The writer (layout.h), the checker (verify.h) and the HDF5 reader share only these names, so that
// the checker does not repeat the writer's mistakes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/plan/failure.h"

namespace sleight::archive {

inline constexpr std::string_view k_format_name = "sleight-archive";
/// The format's version, increased if programs of the older version would misread newer files.
/// Programs read only this version.
inline constexpr std::int64_t k_format_version = 3;
inline constexpr std::string_view k_inference_library = "sleight";

inline constexpr std::string_view k_root = "/";
inline constexpr std::string_view k_posterior = "/posterior";
inline constexpr std::string_view k_sample_stats = "/sample_stats";
inline constexpr std::string_view k_replicas = "/replicas";
inline constexpr std::string_view k_tempering =
    "/tempering";  ///< only if the method learnt something
inline constexpr std::string_view k_animations = "/animations";
/// Scene description: how to draw the animations (common/scene).
inline constexpr std::string_view k_scene = "/scene";
/// Draws from the prior, with ArviZ's names.
inline constexpr std::string_view k_prior = "/prior";
inline constexpr std::string_view k_sample_stats_prior = "/sample_stats_prior";
/// Maximum number of prior draws. Runs of chains make this number of prior draws by default.
inline constexpr std::size_t k_prior_draws_max = 1000;
/// This group is present only if a search found something. Attribute `found`: number of finds, kept
/// or not. Attribute `relax_scans`: number of scans of each relaxation; absent if chains didn't
/// relax the finds.
inline constexpr std::string_view k_finds = "/finds";
inline constexpr std::string_view k_found = "found";
inline constexpr std::string_view k_finds_warning =
    "found by search: each animation ends as requested and is plausible, but the finds are not "
    "in the model's proportions; do not compute averages or odds from them";
inline constexpr std::string_view k_relax_scans = "relax_scans";
inline constexpr std::string_view k_takes_warning =
    "relaxed from a search: the proportions are those of the search; do not compute averages or "
    "odds from these animations";
/// Number of blind throws whose log densities are stored beside the finds' log densities.
inline constexpr std::size_t k_throws = 100;
inline constexpr std::string_view k_request = "request";

/// Root attributes that the digest omits: the digest itself, and attributes that depend on the
/// program's version. So versions of the program that compute the same results produce the same
/// digest.
inline constexpr std::string_view k_content_digest = "content_digest";
inline constexpr std::string_view k_inference_library_version = "inference_library_version";
/// Version of the program that computed the results (deploy/version).
inline constexpr std::string_view k_results_version = "results_version";
/// Identifies the run; equal in all archives of one run.
inline constexpr std::string_view k_run_id = "run_id";

/// Root attribute, present only if users must be warned that the samples are biased.
inline constexpr std::string_view k_warning = "warning";

/// Prefix of root attributes that count failed simulations, such as `failed_search_gave_up`. If a
/// kind of failure occurred in the run, it has such an attribute.
inline constexpr std::string_view k_failed_prefix = "failed_";
/// Attribute of /animations: number of animations that satisfied the constraint but aren't kept,
/// because their motion couldn't be completed. Absent if 0.
inline constexpr std::string_view k_failed_animations = "failed_animations";
inline std::string failed_attribute(plan::FailureKind kind) {
  return std::string(k_failed_prefix) + std::string(plan::name_of(kind));
}

/// Number of a dataset's elements that a writer or reader processes at a time: 128 KiB of doubles.
/// Larger batches are no faster. With much smaller batches, the calls into HDF5 take noticeable
/// time.
inline constexpr std::size_t k_batch_elements = 16384;

/// Longest name of a group, dataset, dimension or attribute. Names consist of letters, digits, '_',
/// '.' and '-', so the digest's manifest, CSV and shells need no quotes around them.
inline constexpr std::size_t k_name_bytes_max = 128;
/// Maximum dimensions of a dataset: chain, draw and the variable's dimensions.
inline constexpr std::size_t k_rank_max = 8;

}  // namespace sleight::archive
