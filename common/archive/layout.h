// The layout of a run's archive: what is written, under which names, in which order.
//
// docs/ARCHIVE_FORMAT.md gives every dataset. Groups, in ArviZ InferenceData's words where they
// fit:
//   /posterior     the state of every thin-th scan: (chain, draw, dimensions of the variable)
//   /sample_stats  scalars of every scan: (chain, draw)
//   /replicas      each replica's newest archived state: (chain, replica, ...)
//   /tempering     what the method learnt of its temperatures: (chain, round, level, ...)
//   /animations    satisfying animations that look different (distinct.h), with their motion
//   /scene         what the animations look like (common/scene)
//   /prior, /sample_stats_prior   draws from the prior
//   /request       the normalised request that reproduces the archive, as text
//
// Invariants:
//  1. The content is a function of the arguments: nothing here reads a clock, the environment or
//     the order in which results came about.
//  2. Memory does not grow with the number of scans: a few batches for each dataset, and at most
//     2 keep_max kept records (distinct.h). The segments of one are held at a time.
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
  std::string request_text;            ///< normalised TOML, not empty, no NUL character
  std::uint64_t thin = 1;              ///< states of scans 0, thin, 2 thin, ...: at least 1
  std::uint64_t keep_max = 5000;       ///< animations in all
  std::uint64_t keep_per_lineage = 3;  ///< animations of one visit to the prior
  double min_distance = 0;             ///< likeness distance, in the world's unit
  // Not part of the digest:
  std::string inference_library_version;  ///< base::version()
  std::string results_version;            ///< of the program that made the results
  std::string run_id;                     ///< the same for all archives of the run
};

/// How far the writing of an archive is.
struct WritingProgress {
  enum class Part : std::uint8_t {
    learning,   ///< what the method learns from the run's scans (who writes it may tell that)
    draws,      ///< the run's draws are written, and animations chosen among them
    animations  ///< the chosen ones are written, each with its motion
  };
  Part part = Part::draws;
  std::uint64_t done = 0;
  std::uint64_t total = 0;  ///< 0: nobody knows
};
using HearWriting = std::function<void(const WritingProgress&)>;

/// Writes everything but content_digest and finish(), which write_digested adds. Throws what the
/// view and the sink throw.
/// `hear` is told often how far it is, and changes nothing; it may be empty.
/// REQUIRES: at least one chain and one scan; records fit the reader's layout and hold a state at
/// every thin-th scan and at every satisfied one; the layout's names are plain words (format.h),
/// unique within each group and none of this format's own.
void write_archive(const RunView& view, const StateReader& reader, const ArchiveOptions& options,
                   Sink& sink, const HearWriting& hear = {});

}  // namespace sleight::archive
