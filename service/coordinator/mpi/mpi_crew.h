// The ranks of an MPI job. All ranks compute blocks together with this process's own threads.
// Worker n is rank n. Rank 0 drives, and computes in additional threads.
//
// Every other rank runs serve() (worker/run/mpi/mpi_worker.h). Only the driving thread calls MPI
// (MPI_THREAD_FUNNELED). The driving thread polls for messages, because a blocking receive would
// occupy a core.
//
// If a rank dies, the whole job dies, because Open MPI 4 can't report which rank died. If the job
// is started again, it resumes from its run store.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/base/clock.h"
#include "common/schema/messages.h"
#include "service/coordinator/crew.h"
#include "service/coordinator/local_crew.h"

namespace sleight::coordinator {

class MpiCrew final : public Crew {
 public:
  /// Rank 0 computes with `local_threads` threads of its own, at least one. Waits for every rank's
  /// hello. Throws base::Error if a hello has a different version or request. REQUIRES: MPI is
  /// initialised with MPI_THREAD_FUNNELED, and this is rank 0's main thread.
  MpiCrew(const plan::BlockWorker& worker, const base::Clock& clock, std::uint32_t local_threads,
          const schema::Hello& expected);
  /// Dismisses the ranks. If an exception is in flight, doesn't, because MPI_Abort will end the
  /// ranks.
  ~MpiCrew() override;
  MpiCrew(const MpiCrew&) = delete;
  MpiCrew& operator=(const MpiCrew&) = delete;

  std::vector<core::Joined> members() const override;
  void send(core::WorkerId worker, schema::Assignment assignment) override;
  void send(core::WorkerId worker, const schema::Ping& ping) override;
  std::vector<core::Input> receive(double timeout_s) override;
  Traffic traffic() const override { return traffic_; }

  /// Asks every rank to exit its loop, and waits for a limited time. False: some ranks haven't
  /// left. MPI_Finalize would then wait forever; MPI_Abort would not wait. Nothing may be sent
  /// afterwards.
  bool dismiss();
  /// Returns whether rank 0's own threads are running blocks.
  bool is_busy() { return local_.is_busy(); }

 private:
  void await_hellos(const schema::Hello& expected);
  /// Receives the messages that have arrived from other ranks. Doesn't wait.
  void poll_ranks(std::vector<core::Input>& inputs);
  void send_to_rank(std::size_t rank, const schema::Message& message);
  void drop_finished_sends();
  /// REQUIRES: every pending message has been received.
  void finish_sends();

  struct Rank {
    std::uint32_t threads = 0;    ///< 0 until the rank's hello
    std::size_t outstanding = 0;  ///< assignments without a delivery
  };
  struct Send;
  const base::Clock& clock_;
  LocalCrew local_;
  std::vector<Rank> ranks_;  ///< by rank; the first is this process
  std::vector<Send> sends_;  ///< not known to be complete, so their bytes must stay alive
  Traffic traffic_;
  bool is_dismissed_ = false;
  std::size_t left_ = 0;  ///< ranks that have announced their leave
};

}  // namespace sleight::coordinator
