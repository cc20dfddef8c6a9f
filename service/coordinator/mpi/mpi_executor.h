// The ranks of an MPI job that compute units, next to this process's own threads.
//
// Rank 0 drives. Every other rank runs serve (worker/run/mpi/mpi_worker.h). Each rank holds at most
// two assignments: the one it computes and one waiting, so that it never waits for a message. Only
// the driving thread calls MPI (MPI_THREAD_FUNNELED); waiting backs off from 20 us to 2 ms, since a
// blocking receive would burn a core.
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
#include "service/coordinator/executor.h"
#include "service/coordinator/local_executor.h"

namespace sleight::coordinator {

inline constexpr std::size_t k_assignments_per_rank = 2;

class MpiExecutor final : public Executor {
 public:
  /// Rank 0 computes with `local_threads` threads of its own, at least one.
  /// Waits for every rank's hello and throws base::Error when one differs in version or request.
  /// REQUIRES: MPI is initialised with MPI_THREAD_FUNNELED, and this is rank 0's main thread.
  MpiExecutor(const plan::UnitWorker& worker, const base::Clock& clock, std::size_t local_threads,
              const schema::Hello& expected);
  /// Tells every rank to leave.
  ~MpiExecutor() override;
  MpiExecutor(const MpiExecutor&) = delete;
  MpiExecutor& operator=(const MpiExecutor&) = delete;

  std::size_t room() const override;
  void submit(const plan::Unit& unit, base::Bytes state) override;
  std::vector<plan::UnitResult> wait(double timeout_s) override;
  /// Those of this process; what a rank has been sent, it computes.
  void drop_waiting() override { local_.drop_waiting(); }
  std::size_t outstanding() const override;
  std::size_t workers() const override;

 private:
  void await_hellos(const schema::Hello& expected);
  /// Takes in what has arrived from other ranks, without waiting.
  void receive(std::vector<plan::UnitResult>& results);
  void send(int rank, const schema::Message& message);
  void drop_finished_sends();

  struct Send;
  const base::Clock& clock_;
  LocalExecutor local_;
  std::vector<std::size_t> assigned_;  ///< by rank - 1: assignments without a result
  std::vector<Send> sends_;            ///< not yet known to be done; their bytes must live on
};

}  // namespace sleight::coordinator
