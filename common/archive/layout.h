// The layout of a run's archive: datasets, names and order.
//
// docs/ARCHIVE_FORMAT.md describes every dataset. Groups, with ArviZ InferenceData's names where
// possible:
//   /posterior     the state of every thin-th scan: (chain, draw, dimensions of the variable)
//   /sample_stats  scalars of every scan: (chain, draw)
//   /replicas      each replica's newest archived state: (chain, replica, ...)
//   /tempering     what the method learnt about its temperatures: (chain, round, level, ...)
//   /animations    satisfying animations that look different (distinct.h), with their motions
//   /scene         how to draw the animations (common/scene)
//   /prior, /sample_stats_prior   draws from the prior
//   /request       the normalised request that reproduces the archive, as text
//
// Invariants:
//  1. The content is a function of the arguments. The content does not depend on a clock, the
//     environment or the order of results.
//  2. Memory does not grow with the number of scans: a few batches per dataset, and at most 2
//     keep_max kept records (distinct.h). Only one animation's segments are in memory at a time.
//  3. An entry that does not apply is NaN.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "common/archive/model.h"
#include "common/archive/run_view.h"
#include "common/archive/world_layout.h"

namespace sleight::archive {

struct ArchiveOptions {
  std::string request_text;            ///< normalised TOML, non-empty, no NUL character
  std::uint64_t thin = 1;              ///< store states of scans 0, thin, 2 thin, ...; at least 1
  std::uint64_t keep_max = 5000;       ///< maximum animations in all
  std::uint64_t keep_per_lineage = 3;  ///< maximum animations per lineage
  double min_distance = 0;             ///< minimum likeness distance, in the world's unit
  // Not covered by the digest:
  std::string inference_library_version;  ///< base::version()
  std::string results_version;            ///< of the program that computed the results
  std::string run_id;                     ///< equal in all archives of the run
};

struct WritingProgress {
  enum class Part : std::uint8_t {
    learning,   ///< learning from the run's scans; reported only by some callers
    draws,      ///< writing draws and selecting animations
    animations  ///< writing the selected animations and their motions
  };
  Part part = Part::draws;
  std::uint64_t done = 0;
  std::uint64_t total = 0;  ///< 0: unknown
};
using HearWriting = std::function<void(const WritingProgress&)>;

/// Writes the archive, but not content_digest, and doesn't call finish(). write_digested does both.
/// Passes on exceptions of the view and the sink. Often calls `hear` with the progress; `hear` may
/// be empty. REQUIRES: at least one chain and one scan. Records fit the reader's layout. Each
/// thin-th scan and each satisfied scan has a state. The layout's names are plain words (format.h)
/// and unique within each group. None is a name of the format itself.
void write_archive(const RunView& view, const StateReader& reader, const ArchiveOptions& options,
                   Sink& sink, const HearWriting& hear = {});

}  // namespace sleight::archive
