// In-memory archives of the made-up world.
#pragma once

#include <cstdint>

#include "common/archive/digest/digest.h"
#include "tests/archive/memory_archive.h"
#include "tests/unit/common/archive/fake_world.h"

namespace sleight::gallery::testing {

/// Returns an archive that keeps all animations of one chain. If a run is longer, its archive
/// begins with the shorter run's animations.
inline archive::MemoryArchive made_up(std::uint64_t scans, std::uint64_t finds = 0) {
  using namespace archive::testing;
  const FakeRunOptions run{.seed = 1, .chains = 1, .scans = scans, .finds = finds};
  archive::MemoryArchive memory;
  archive::write_digested(memory, [&](archive::Sink& sink) {
    archive::ArchiveOptions options = options_for(run);
    options.keep_max = 1000;
    options.keep_per_lineage = 1000;
    archive::write_archive(FakeRun(run), FakeReader(), options, sink);
  });
  return memory;
}

}  // namespace sleight::gallery::testing
