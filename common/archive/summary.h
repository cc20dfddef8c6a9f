// What an archive says about itself: its root attributes, its request and its sizes.
#pragma once

#include <cstdint>
#include <string>

#include "common/archive/model.h"
#include "common/plan/failure.h"

namespace sleight::archive {

/// Of a search; all 0 where there was none.
struct FindsSummary {
  std::uint64_t found = 0;
  std::uint64_t relax_scans = 0;  ///< of the chains that relaxed them; 0: none did
  std::uint64_t animations = 0;   ///< of these, kept
  std::uint64_t segments = 0;
};

struct Summary {
  std::int64_t format_version = 0;
  std::string world;
  std::string inference_library_version;
  std::string results_version;  ///< of the program that made the results
  std::string run_id;           ///< the same for all archives of a run
  std::string content_digest;   ///< as stored, not recomputed
  std::string warning;          ///< what must be known of the samples; empty: nothing
  std::string request_text;     ///< normalised TOML that reproduces the archive
  std::uint64_t chains = 0;
  std::uint64_t scans = 0;   ///< of each chain
  std::uint64_t states = 0;  ///< of each chain, in /posterior
  std::int64_t thin = 0;
  std::int64_t keep_max = 0;          ///< most animations kept
  std::int64_t keep_per_lineage = 0;  ///< most of one lineage
  std::uint64_t animations = 0;
  std::uint64_t segments = 0;
  plan::FailureCounts failures{};       ///< simulations that failed, by kind
  std::uint64_t failed_animations = 0;  ///< satisfied, but not simulated to their end
  FindsSummary finds{};
};

/// Throws base::Error with ExitCode::bad_archive that names what is missing or of another type.
Summary summary_of(const Source& source);

}  // namespace sleight::archive
