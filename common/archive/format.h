// Names, version and limits of the sample archive: docs/ARCHIVE_FORMAT.md says what they mean.
//
// The writer (layout.h), the checker (verify.h) and the HDF5 reader share these words and nothing
// else, so that the checker is a second opinion and no echo of the writer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/plan/failure.h"

namespace sleight::archive {

inline constexpr std::string_view k_format_name = "sleight-archive";
/// Raised when a reader of the older version would misread the newer file. No other is read.
inline constexpr std::int64_t k_format_version = 3;
inline constexpr std::string_view k_inference_library = "sleight";

inline constexpr std::string_view k_root = "/";
inline constexpr std::string_view k_posterior = "/posterior";
inline constexpr std::string_view k_sample_stats = "/sample_stats";
inline constexpr std::string_view k_replicas = "/replicas";
inline constexpr std::string_view k_tempering = "/tempering";  ///< only where something was learnt
inline constexpr std::string_view k_animations = "/animations";
/// What animations look like (common/scene).
inline constexpr std::string_view k_scene = "/scene";
/// Draws from the prior, by ArviZ's names.
inline constexpr std::string_view k_prior = "/prior";
inline constexpr std::string_view k_sample_stats_prior = "/sample_stats_prior";
/// At most, and of a run of chains that does not say otherwise.
inline constexpr std::size_t k_prior_draws_max = 1000;
/// Only where a search found something, with the attributes `found`: how many, kept or not; and,
/// where chains relaxed them, `relax_scans`: for so many scans.
inline constexpr std::string_view k_finds = "/finds";
inline constexpr std::string_view k_found = "found";
inline constexpr std::string_view k_finds_warning =
    "found by search: each animation ends as requested and is plausible, but the finds are not "
    "in the model's proportions; do not compute averages or odds from them";
inline constexpr std::string_view k_relax_scans = "relax_scans";
inline constexpr std::string_view k_takes_warning =
    "relaxed from a search: proportions are the search's; do not compute averages or odds";
/// Blind throws whose log densities stand beside those of finds.
inline constexpr std::size_t k_throws = 100;
inline constexpr std::string_view k_request = "request";

/// Root attributes that the digest leaves out: the digest itself, and what the program's version
/// enters, so that two versions which compute the same results have the same digest.
inline constexpr std::string_view k_content_digest = "content_digest";
inline constexpr std::string_view k_inference_library_version = "inference_library_version";
/// Of the program that made the results (deploy/version).
inline constexpr std::string_view k_results_version = "results_version";
/// Which run it is: the same for all archives of one run, whatever their cuts.
inline constexpr std::string_view k_run_id = "run_id";

/// Root attribute, only there where something must be known of the samples: that they are biased.
inline constexpr std::string_view k_warning = "warning";

/// Root attributes `failed_search_gave_up` and so on, one for each kind of failure that simulations
/// of the run had; none where all went well.
inline constexpr std::string_view k_failed_prefix = "failed_";
/// Attribute of /animations, only there where some that satisfied could not be simulated to their
/// end, and so are not kept.
inline constexpr std::string_view k_failed_animations = "failed_animations";
inline std::string failed_attribute(plan::FailureKind kind) {
  return std::string(k_failed_prefix) + std::string(plan::name_of(kind));
}

/// Elements that one pass over a dataset holds at a time, in every writer and reader: 128 KiB of
/// doubles. More buys no speed; much less makes the calls into HDF5 show.
inline constexpr std::size_t k_batch_elements = 16384;

/// Longest name of a group, dataset, dimension or attribute. Names are letters, digits, '_', '.'
/// and '-', so they need no quoting in the digest's manifest, in CSV or in a shell.
inline constexpr std::size_t k_name_bytes_max = 128;
/// Most dimensions of a dataset: chain, draw and those of the variable.
inline constexpr std::size_t k_rank_max = 8;

}  // namespace sleight::archive
