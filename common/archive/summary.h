// An archive's root attributes, request and sizes.
#pragma once

#include <cstdint>
#include <string>

#include "common/archive/model.h"
#include "common/plan/failure.h"

namespace sleight::archive {

/// Finds of a search. If there was no search, all counts are 0.
struct FindsSummary {
  std::uint64_t found = 0;
  std::uint64_t relax_scans = 0;  ///< of the chains that relaxed the finds; 0: not relaxed
  std::uint64_t animations = 0;   ///< number of kept finds
  std::uint64_t segments = 0;
};

struct Summary {
  std::int64_t format_version = 0;
  std::string world;
  std::string inference_library_version;
  std::string results_version;  ///< of the program that computed the results
  std::string run_id;           ///< equal in all archives of a run
  std::string content_digest;   ///< as stored, not recomputed
  std::string warning;          ///< what users of the samples must know; empty: nothing
  std::string request_text;     ///< normalised TOML that reproduces the archive
  std::uint64_t chains = 0;
  std::uint64_t scans = 0;   ///< per chain
  std::uint64_t states = 0;  ///< per chain, in /posterior
  std::int64_t thin = 0;
  std::int64_t keep_max = 0;          ///< maximum kept animations
  std::int64_t keep_per_lineage = 0;  ///< maximum per lineage
  std::uint64_t animations = 0;
  std::uint64_t segments = 0;
  plan::FailureCounts failures{};       ///< failed simulations, by kind
  std::uint64_t failed_animations = 0;  ///< satisfying, but the motion couldn't be completed
  FindsSummary finds{};
};

/// Throws base::Error with ExitCode::bad_archive if a part is missing or has the wrong type, and
/// names the part.
Summary summary_of(const Source& source);

}  // namespace sleight::archive
