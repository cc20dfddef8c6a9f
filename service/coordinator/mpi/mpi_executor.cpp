#include "service/coordinator/mpi/mpi_executor.h"

#include <fmt/format.h>
#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <numeric>
#include <optional>
#include <thread>
#include <utility>

#include "common/base/check.h"
#include "common/base/error.h"

namespace sleight::coordinator {
namespace {

/// Ranks start within a second or so of one another; this is for a machine under heavy load.
constexpr double k_hello_timeout_s = 120;

int count_other_ranks() {
  int ranks = 0;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  return ranks - 1;
}

void sleep_s(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

struct Received {
  int rank = 0;
  schema::Message message;
};

/// The next message that has arrived, if any.
std::optional<Received> poll() {
  int arrived = 0;
  MPI_Status status;
  MPI_Iprobe(MPI_ANY_SOURCE, schema::k_message_tag, MPI_COMM_WORLD, &arrived, &status);
  if (arrived == 0) return std::nullopt;
  int size = 0;
  MPI_Get_count(&status, MPI_BYTE, &size);
  base::Bytes bytes(static_cast<std::size_t>(size));
  MPI_Recv(bytes.data(), size, MPI_BYTE, status.MPI_SOURCE, schema::k_message_tag, MPI_COMM_WORLD,
           MPI_STATUS_IGNORE);
  base::Result<schema::Message, std::string> message = schema::decode(bytes);
  if (!message) {
    throw base::Error(base::ExitCode::bug,
                      fmt::format("rank {} sent {}", status.MPI_SOURCE, message.error()));
  }
  return Received{.rank = status.MPI_SOURCE, .message = std::move(message).value()};
}

}  // namespace

struct MpiExecutor::Send {
  std::unique_ptr<base::Bytes> bytes;
  MPI_Request request = MPI_REQUEST_NULL;
};

MpiExecutor::MpiExecutor(const plan::UnitWorker& worker, const base::Clock& clock,
                         std::size_t local_threads, const schema::Hello& expected)
    : clock_(clock),
      local_(worker, clock, local_threads),
      assigned_(static_cast<std::size_t>(count_other_ranks()), 0) {
  await_hellos(expected);
}

MpiExecutor::~MpiExecutor() {
  // Results on their way are received and dropped, so that no rank is stuck in a send; a rank that
  // doesn't answer is left to mpirun.
  const double begin_s = clock_.now_s();
  std::vector<plan::UnitResult> dropped;
  while (std::any_of(assigned_.begin(), assigned_.end(), [](std::size_t n) { return n > 0; }) &&
         clock_.now_s() - begin_s < k_hello_timeout_s) {
    try {
      receive(dropped);
    } catch (const base::Error&) {
      break;
    }
    sleep_s(schema::k_poll_interval_s_max);
  }
  for (std::size_t i = 0; i < assigned_.size(); ++i)
    send(static_cast<int>(i) + 1, schema::Stop{});
  for (Send& pending : sends_)
    MPI_Wait(&pending.request, MPI_STATUS_IGNORE);
}

void MpiExecutor::await_hellos(const schema::Hello& expected) {
  const double begin_s = clock_.now_s();
  for (std::size_t heard = 0; heard < assigned_.size();) {
    std::optional<Received> received = poll();
    if (!received) {
      if (clock_.now_s() - begin_s > k_hello_timeout_s) {
        throw base::Error(fmt::format("{} of {} ranks have not reported within {} s",
                                      assigned_.size() - heard, assigned_.size(),
                                      k_hello_timeout_s));
      }
      sleep_s(schema::k_poll_interval_s_max);
      continue;
    }
    if (const auto* failure = std::get_if<schema::Failure>(&received->message)) {
      throw base::Error(fmt::format("rank {}: {}", received->rank, failure->reason));
    }
    const auto* hello = std::get_if<schema::Hello>(&received->message);
    CHECK(hello != nullptr);
    if (hello->program_version != expected.program_version) {
      throw base::Error(fmt::format(
          "rank {} runs version {}, rank 0 runs {}: install the same version on every host",
          received->rank, hello->program_version, expected.program_version));
    }
    if (hello->identity != expected.identity) {
      throw base::Error(
          fmt::format("rank {} reads another request than rank 0: give every host the same file",
                      received->rank));
    }
    ++heard;
  }
}

std::size_t MpiExecutor::room() const {
  const std::size_t taken = std::accumulate(assigned_.begin(), assigned_.end(), std::size_t{0});
  return k_assignments_per_rank * assigned_.size() - taken + local_.room();
}

std::size_t MpiExecutor::outstanding() const {
  return std::accumulate(assigned_.begin(), assigned_.end(), local_.outstanding());
}

std::size_t MpiExecutor::workers() const {
  return assigned_.size() + local_.workers();
}

void MpiExecutor::submit(const plan::Unit& unit, base::Bytes state) {
  // The least loaded rank takes it; this process's threads when no rank has less.
  const auto least = std::min_element(assigned_.begin(), assigned_.end());
  const std::size_t local_load = local_.outstanding() / std::max<std::size_t>(local_.workers(), 1);
  const bool ranks_full = least == assigned_.end() || *least >= k_assignments_per_rank;
  if (ranks_full || (local_.room() > 0 && local_load <= *least)) {
    local_.submit(unit, std::move(state));
    return;
  }
  ++*least;
  send(static_cast<int>(least - assigned_.begin()) + 1,
       schema::Assignment{.unit = unit, .state = std::move(state)});
}

std::vector<plan::UnitResult> MpiExecutor::wait(double timeout_s) {
  const double begin_s = clock_.now_s();
  double backoff_s = schema::k_poll_interval_s_min;
  std::vector<plan::UnitResult> results;
  while (true) {
    receive(results);
    for (plan::UnitResult& result : local_.wait(results.empty() ? backoff_s : 0)) {
      results.push_back(std::move(result));
    }
    if (!results.empty() || clock_.now_s() - begin_s >= timeout_s) return results;
    backoff_s = std::min(2 * backoff_s, schema::k_poll_interval_s_max);
  }
}

void MpiExecutor::receive(std::vector<plan::UnitResult>& results) {
  drop_finished_sends();
  while (std::optional<Received> received = poll()) {
    if (auto* failure = std::get_if<schema::Failure>(&received->message)) {
      throw base::Error(fmt::format("rank {}: {}", received->rank, failure->reason));
    }
    auto* result = std::get_if<plan::UnitResult>(&received->message);
    CHECK(result != nullptr);
    std::size_t& assigned = assigned_[static_cast<std::size_t>(received->rank) - 1];
    CHECK_GT(assigned, 0U);
    --assigned;
    results.push_back(std::move(*result));
  }
}

void MpiExecutor::send(int rank, const schema::Message& message) {
  Send& pending = sends_.emplace_back();
  pending.bytes = std::make_unique<base::Bytes>(schema::encode(message));
  MPI_Isend(pending.bytes->data(), static_cast<int>(pending.bytes->size()), MPI_BYTE, rank,
            schema::k_message_tag, MPI_COMM_WORLD, &pending.request);
}

void MpiExecutor::drop_finished_sends() {
  std::erase_if(sends_, [](Send& pending) {
    int done = 0;
    MPI_Test(&pending.request, &done, MPI_STATUS_IGNORE);
    return done != 0;
  });
}

}  // namespace sleight::coordinator
