// Jobs as clients see them. Thread safety: pure functions of their arguments.
#pragma once

#include <string>

#include "common/events/progress.h"
#include "common/rpc/service.h"
#include "service/daemon/board.h"
#include "service/daemon/job_store.h"
#include "service/jobs/jobs.h"

namespace sleight::daemon {

rpc::JobId rpc_id(jobs::JobId job);
jobs::JobId job_id(rpc::JobId job);
rpc::JobState rpc_state(jobs::State state);
/// REQUIRES: the kind is known.
jobs::AskKind ask_kind(rpc::ChangeKind kind);

/// Data from which view_of() makes a job's view.
struct ViewOf {
  const Posted& posted;
  const jobs::Jobs& machine;
  const events::Progress* progress = nullptr;  ///< newest; null: unknown
};
rpc::JobView view_of(const ViewOf& what);

rpc::StateChange change_of(const JobReader::NumberedChange& change);

/// Returns the sentence that explains the job's state. If there is no sentence, returns the
/// reason's name with blanks instead of underscores.
std::string reason_of(const jobs::Job& job);

rpc::Refusal refusal_of(const jobs::Refusal& refusal);

}  // namespace sleight::daemon
