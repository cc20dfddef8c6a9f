#include "worker/run/mpi/mpi_worker.h"

#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <string>
#include <thread>
#include <utility>

#include "common/base/check.h"

namespace sleight::run {
namespace {

constexpr int k_coordinator_rank = 0;

void send(const schema::Message& message) {
  const base::Bytes bytes = schema::encode(message);
  MPI_Send(bytes.data(), static_cast<int>(bytes.size()), MPI_BYTE, k_coordinator_rank,
           schema::k_message_tag, MPI_COMM_WORLD);
}

/// Waits for a message without burning the core.
base::Bytes receive() {
  double backoff_s = schema::k_poll_interval_s_min;
  int arrived = 0;
  MPI_Status status;
  while (true) {
    MPI_Iprobe(k_coordinator_rank, schema::k_message_tag, MPI_COMM_WORLD, &arrived, &status);
    if (arrived != 0) break;
    std::this_thread::sleep_for(std::chrono::duration<double>(backoff_s));
    backoff_s = std::min(2 * backoff_s, schema::k_poll_interval_s_max);
  }
  int size = 0;
  MPI_Get_count(&status, MPI_BYTE, &size);
  base::Bytes bytes(static_cast<std::size_t>(size));
  MPI_Recv(bytes.data(), size, MPI_BYTE, k_coordinator_rank, schema::k_message_tag, MPI_COMM_WORLD,
           MPI_STATUS_IGNORE);
  return bytes;
}

}  // namespace

void refuse(const std::string& reason) {
  send(schema::Failure{.reason = reason});
}

void serve(const plan::UnitWorker& worker, const base::Clock& clock, const schema::Hello& hello) {
  send(hello);
  while (true) {
    base::Result<schema::Message, std::string> message = schema::decode(receive());
    if (!message) {
      refuse("got " + message.error());
      return;
    }
    const auto* assignment = std::get_if<schema::Assignment>(&message.value());
    if (assignment == nullptr) {
      CHECK(std::holds_alternative<schema::Stop>(message.value()));
      return;
    }
    try {
      const double begin_s = clock.now_s();
      plan::UnitResult result = worker.run(assignment->unit, assignment->state);
      result.cost_s = clock.now_s() - begin_s;
      send(std::move(result));
    } catch (const std::exception& failure) {
      refuse(failure.what());
      return;
    }
  }
}

}  // namespace sleight::run
