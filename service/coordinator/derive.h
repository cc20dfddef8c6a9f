// Archives out of a run's store: at the end of a session, now and then while it runs, and by
// `sleight archive derive` beside it or long after.
//
// Nothing of the running session is needed: rows of a cut never change, and what a method learns
// from them a fresh plan learns again. So an archive of one cut is the same whenever and by
// whomever it is derived.
//
// Thread safety: one archive at a time in the process (hdf5/writer.h), in any thread.
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

/// What decides the stored results of a run: two requests with one identity can share a run store,
/// so that one goes on where the other stopped. [stop] and what is kept in the archive may differ;
/// `thin` may not, since only every thin-th scan's state is stored.
std::string run_identity(const request::DirectionRequest& request);

/// Borrowed for the call.
struct DeriveInputs {
  const request::DirectionRequest& request;
  const archive::StateReader& reader;
  /// A fresh plan of the run that ends at a cut.
  const std::function<std::unique_ptr<plan::Plan>(const request::Cut& cut)>& plan_of;
  base::FileSystem& files;
  /// Of the program, which made the run's results.
  const std::string& results_version;
  /// Where the processor time in seconds is added that motions took which were not remembered; may
  /// be null.
  double* motions_s = nullptr;
  /// Through which the store is read, which on a network disk is the writer's own
  /// (RunStore::to_read); null: a connection of its own.
  std::shared_ptr<store::SharedDatabase> store{};
  /// Asked between batches and before the archive gets its name; throws where the run may be
  /// another process's by now. May be empty.
  std::function<void()> fence{};
  /// Told often how far the archive is; may be empty.
  archive::HearWriting hear{};
};

/// Thrown out of derive_archive when it was stopped; nothing was written.
struct DeriveStopped {};

/// Writes the archive of a cut of the run in `folder` to `output`, beside its place and renamed.
/// Returns its digest; empty, and no archive, while the run is in its burn-in and has found
/// nothing. `cut` is then what the archive holds: no scans where these are no draws yet. Motions
/// are remembered in the folder (store/stored_motions.h). Throws base::Error where the store can't
/// be read or the archive can't be written, and DeriveStopped soon after `stop` has become true:
/// after one simulation, or a batch. It is asked in this thread and may be empty. REQUIRES: the cut
/// is committed.
std::string derive_archive(const DeriveInputs& inputs, const std::string& folder,
                           const std::string& output, request::Cut& cut,
                           const std::function<bool()>& stop = {});

/// What is committed in `folder` of a run of this request.
request::Cut committed_cut(const std::string& folder, plan::Plan& fresh_plan);

}  // namespace sleight::coordinator
