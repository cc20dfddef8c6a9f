// Derives archives from a run's store. A session derives archives periodically and at its end;
// `sleight archive derive` can derive one at any time.
//
// Deriving depends only on the store. Rows of a cut never change. So a fresh plan learns from them
// what the run's method learned. So a cut's archive doesn't depend on when or in which process it
// is derived.
//
// Thread safety: one archive at a time per process (hdf5/writer.h), in any thread.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "common/archive/layout.h"
#include "common/archive/world_layout.h"
#include "common/base/file_system.h"
#include "common/plan/plan.h"
#include "common/request/direction_request.h"
#include "common/store/shared_database.h"

namespace sleight::coordinator {

/// Identifies what determines a run's stored results. If two requests have the same identity, one
/// can resume the other's run in the same run store. Such requests may differ in [stop] and in the
/// kept animations. They can't differ in `thin`, because only every thin-th scan's state is stored.
std::string run_identity(const request::DirectionRequest& request);

/// Inputs that are borrowed for the call.
struct DeriveInputs {
  const request::DirectionRequest& request;
  const archive::StateReader& reader;
  /// Returns a fresh plan of the run that ends at a cut.
  const std::function<std::unique_ptr<plan::Plan>(const request::Cut& cut)>& plan_of;
  base::FileSystem& files;
  /// Results version of the program that computed the run.
  const std::string& results_version;
  /// Processor seconds for simulating new motions are added to this number. May be null.
  double* motions_s = nullptr;
  /// The connection for reading. On a network disk it is the writer's connection
  /// (RunStore::to_read). Null: open a new one.
  std::shared_ptr<store::SharedDatabase> store{};
  /// Called between batches and before renaming. Throws if the run may belong to another process by
  /// now. May be empty.
  std::function<void()> fence{};
  /// Receives the progress of writing. May be empty.
  archive::HearWriting hear{};
};

/// Thrown if derive_archive was stopped. It has written nothing.
struct DeriveStopped {};

/// Derives an archive from a cut of the run in `folder`. Writes a temporary file and renames it to
/// `output`. Returns the archive's digest. While the run is in its burn-in and has found nothing,
/// returns an empty digest and writes nothing. Sets `cut` to the archive's content. If no scan is a
/// draw yet, the archive has no scans. Motions are saved in the folder (store/stored_motions.h).
/// Throws base::Error if the store can't be read or the archive can't be written. After `stop`
/// returns true, throws DeriveStopped within one simulation or one batch. `stop` is called in this
/// thread and may be empty. REQUIRES: the cut is committed.
std::string derive_archive(const DeriveInputs& inputs, const std::string& folder,
                           const std::string& output, request::Cut& cut,
                           const std::function<bool()>& stop = {});

/// Returns the committed cut of this request's run in `folder`.
request::Cut committed_cut(const std::string& folder, plan::Plan& fresh_plan);

}  // namespace sleight::coordinator
