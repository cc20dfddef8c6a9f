// The ranks of an MPI job that compute blocks, next to this process's own threads. Worker n is rank
// n; rank 0 drives, and computes with threads of its own beside it.
//
// Every other rank runs serve (worker/run/mpi/mpi_worker.h). Only the driving thread calls MPI
// (MPI_THREAD_FUNNELED); it looks for messages every half millisecond, since a blocking receive
// would burn a core.
//
// A rank that dies takes the whole job with it (Open MPI 4 can't say which rank is gone): the job
// is started again and goes on from its run store.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/clock.h"
#include "common/schema/messages.h"
#include "service/coordinator/crew.h"
#include "service/coordinator/local_crew.h"

namespace sleight::coordinator {

class MpiCrew final : public Crew {
 public:
  /// Rank 0 computes with `local_threads` threads of its own, at least one.
  /// Waits for every rank's hello and throws base::Error when one differs in version or request.
  /// REQUIRES: MPI is initialised with MPI_THREAD_FUNNELED, and this is rank 0's main thread.
  MpiCrew(const plan::BlockWorker& worker, const base::Clock& clock, std::uint32_t local_threads,
          const schema::Hello& expected);
  /// Dismisses the ranks; while an exception passes it leaves them to MPI_Abort.
  ~MpiCrew() override;
  MpiCrew(const MpiCrew&) = delete;
  MpiCrew& operator=(const MpiCrew&) = delete;

  std::vector<core::Joined> members() const override;
  void send(core::WorkerId worker, schema::Assignment assignment) override;
  void send(core::WorkerId worker, const schema::Ping& ping) override;
  std::vector<core::Input> receive(double timeout_s) override;
  Traffic traffic() const override { return traffic_; }

  /// Tells every rank to leave, and waits for that a while: false when some haven't. MPI_Finalize
  /// would then wait for them for ever, MPI_Abort doesn't. Nothing may be sent afterwards.
  bool dismiss();
  /// Whether rank 0's own threads are at work, as LocalCrew has it.
  bool is_busy() { return local_.is_busy(); }

 private:
  void await_hellos(const schema::Hello& expected);
  /// Takes in what has arrived from other ranks, without waiting.
  void poll_ranks(std::vector<core::Input>& inputs);
  void send_to_rank(std::size_t rank, const schema::Message& message);
  void drop_finished_sends();
  /// REQUIRES: their receivers have had them.
  void finish_sends();

  struct Rank {
    std::uint32_t threads = 0;    ///< 0 until its hello
    std::size_t outstanding = 0;  ///< assignments without a delivery
  };
  struct Send;
  const base::Clock& clock_;
  LocalCrew local_;
  std::vector<Rank> ranks_;  ///< by rank; the first is this one
  std::vector<Send> sends_;  ///< not yet known to be done; their bytes must live on
  Traffic traffic_;
  bool is_dismissed_ = false;
  std::size_t left_ = 0;  ///< ranks that have said that they leave
};

}  // namespace sleight::coordinator
