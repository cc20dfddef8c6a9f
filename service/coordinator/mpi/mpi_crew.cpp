#include "service/coordinator/mpi/mpi_crew.h"

#include <fmt/format.h>
#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "common/base/error.h"
#include "common/logging/log.h"
#include "common/schema/wire/wire.h"

namespace sleight::coordinator {
namespace {

/// Ranks usually start within about a second. On a heavily loaded machine, they take longer.
constexpr double k_hello_timeout_s = 120;
/// A rank leaves after its current block. After this time, rank 0 stops waiting for a hanging rank.
constexpr double k_leave_timeout_s = 20;
/// Maximum time until a delivery is noticed. Meanwhile most ranks have another block queued, but a
/// rank that ran a whole ladder waits. Each poll takes processor time from the computing threads.
/// Results of rank 0's own threads wake the loop at once.
constexpr double k_coordinator_poll_s = 0.3e-3;

std::size_t count_ranks() {
  int ranks = 0;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  return static_cast<std::size_t>(ranks);
}

void sleep_s(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

base::Error unexpected_from(std::size_t rank) {
  return {base::ExitCode::bug, fmt::format("rank {} sent an unexpected message", rank)};
}

struct Received {
  std::size_t rank = 0;
  std::size_t bytes = 0;
  schema::Message message;
};

/// Returns the next message that has arrived, if any.
std::optional<Received> poll() {
  int arrived = 0;
  MPI_Status status;
  MPI_Iprobe(MPI_ANY_SOURCE, schema::wire::k_message_tag, MPI_COMM_WORLD, &arrived, &status);
  if (arrived == 0) return std::nullopt;
  int size = 0;
  MPI_Get_count(&status, MPI_BYTE, &size);
  base::Bytes bytes(static_cast<std::size_t>(size));
  MPI_Recv(bytes.data(), size, MPI_BYTE, status.MPI_SOURCE, schema::wire::k_message_tag,
           MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  base::Result<schema::Message, std::string> message = schema::wire::decode(bytes);
  if (!message) {
    throw base::Error(base::ExitCode::bug, fmt::format("invalid message from rank {}: {}",
                                                       status.MPI_SOURCE, message.error()));
  }
  return Received{.rank = static_cast<std::size_t>(status.MPI_SOURCE),
                  .bytes = bytes.size(),
                  .message = std::move(message).value()};
}

}  // namespace

struct MpiCrew::Send {
  std::unique_ptr<base::Bytes> bytes;
  MPI_Request request = MPI_REQUEST_NULL;
};

MpiCrew::MpiCrew(const plan::BlockWorker& worker, const base::Clock& clock,
                 std::uint32_t local_threads, const schema::Hello& expected)
    : clock_(clock), local_(worker, local_threads), ranks_(count_ranks()) {
  await_hellos(expected);
}

MpiCrew::~MpiCrew() {
  // After a failure, main aborts the job. Other ranks may have failed too, so don't wait for them.
  if (std::uncaught_exceptions() == 0 && dismiss()) return;
  // If a rank hasn't exited, messages to it must outlive this object.
  for (Send& pending : sends_)
    static_cast<void>(pending.bytes.release());
}

bool MpiCrew::dismiss() {
  const std::size_t others = ranks_.size() - 1;
  if (!std::exchange(is_dismissed_, true)) {
    for (std::size_t rank = 1; rank <= others; ++rank)
      send_to_rank(rank, schema::Stop{});
    // Receive and drop late deliveries, so that no rank blocks in a send.
    const double begin_s = clock_.now_s();
    std::vector<core::Input> dropped;
    try {
      while (left_ < others && clock_.now_s() - begin_s < k_leave_timeout_s) {
        poll_ranks(dropped);
        dropped.clear();
        sleep_s(schema::wire::k_poll_interval_s_max);
      }
    } catch (const base::Error& failure) {
      logging::warn(fmt::format("error after the end of the run: {}", failure.what()));
    }
    if (left_ == others) finish_sends();
  }
  return left_ == others;
}

std::vector<core::Joined> MpiCrew::members() const {
  std::vector<core::Joined> members = local_.members();
  for (std::size_t rank = 1; rank < ranks_.size(); ++rank)
    members.push_back({.worker = core::WorkerId{static_cast<std::uint32_t>(rank)},
                       .incarnation = 0,
                       .threads = ranks_[rank].threads});
  return members;
}

void MpiCrew::await_hellos(const schema::Hello& expected) {
  const double begin_s = clock_.now_s();
  const std::size_t others = ranks_.size() - 1;
  for (std::size_t heard = 0; heard < others;) {
    std::optional<Received> received = poll();
    if (!received) {
      if (clock_.now_s() - begin_s > k_hello_timeout_s) {
        throw base::Error(fmt::format("{} of {} ranks did not report within {} s", others - heard,
                                      others, k_hello_timeout_s));
      }
      sleep_s(schema::wire::k_poll_interval_s_max);
      continue;
    }
    if (const auto* failure = std::get_if<schema::Failure>(&received->message)) {
      throw base::Error(fmt::format("rank {}: {}", received->rank, failure->reason));
    }
    const auto* hello = std::get_if<schema::Hello>(&received->message);
    if (hello == nullptr) throw unexpected_from(received->rank);
    if (hello->results_version != expected.results_version) {
      throw base::Error(
          fmt::format("rank {} has results version {}, but rank 0 has {}; install the same version "
                      "on every host",
                      received->rank, hello->results_version, expected.results_version));
    }
    if (hello->identity != expected.identity) {
      throw base::Error(
          fmt::format("rank {} has a different request than rank 0; give every host the same file",
                      received->rank));
    }
    ranks_.at(received->rank).threads = hello->threads;
    ++heard;
  }
}

void MpiCrew::send(core::WorkerId worker, schema::Assignment assignment) {
  if (worker == k_local_worker) {
    local_.send(worker, std::move(assignment));
    return;
  }
  ++ranks_.at(worker.value).outstanding;
  send_to_rank(worker.value, std::move(assignment));
}

void MpiCrew::send(core::WorkerId worker, const schema::Ping& ping) {
  if (worker == k_local_worker) {
    local_.send(worker, ping);
  } else {
    send_to_rank(worker.value, ping);
  }
}

std::vector<core::Input> MpiCrew::receive(double timeout_s) {
  const double begin_s = clock_.now_s();
  std::vector<core::Input> inputs;
  while (true) {
    poll_ranks(inputs);
    for (core::Input& input : local_.receive(inputs.empty() ? k_coordinator_poll_s : 0))
      inputs.push_back(std::move(input));
    if (!inputs.empty() || clock_.now_s() - begin_s >= timeout_s) return inputs;
  }
}

void MpiCrew::poll_ranks(std::vector<core::Input>& inputs) {
  drop_finished_sends();
  while (std::optional<Received> received = poll()) {
    ++traffic_.messages;
    traffic_.bytes += received->bytes;
    if (auto* failure = std::get_if<schema::Failure>(&received->message)) {
      throw base::Error(fmt::format("rank {}: {}", received->rank, failure->reason));
    }
    const core::WorkerId worker{static_cast<std::uint32_t>(received->rank)};
    if (auto* pong = std::get_if<schema::Pong>(&received->message)) {
      inputs.emplace_back(core::Answered{.worker = worker, .pong = std::move(*pong)});
      continue;
    }
    if (std::holds_alternative<schema::Stop>(received->message) && is_dismissed_) {
      ++left_;
      continue;
    }
    auto* delivery = std::get_if<schema::Delivery>(&received->message);
    Rank& rank = ranks_.at(received->rank);
    if (delivery == nullptr || rank.outstanding == 0) throw unexpected_from(received->rank);
    --rank.outstanding;
    inputs.emplace_back(core::Delivered{.worker = worker, .delivery = std::move(*delivery)});
  }
}

void MpiCrew::send_to_rank(std::size_t rank, const schema::Message& message) {
  Send& pending = sends_.emplace_back();
  pending.bytes = std::make_unique<base::Bytes>(schema::wire::encode(message));
  ++traffic_.messages;
  traffic_.bytes += pending.bytes->size();
  MPI_Isend(pending.bytes->data(), static_cast<int>(pending.bytes->size()), MPI_BYTE,
            static_cast<int>(rank), schema::wire::k_message_tag, MPI_COMM_WORLD, &pending.request);
}

void MpiCrew::finish_sends() {
  for (Send& pending : sends_)
    MPI_Wait(&pending.request, MPI_STATUS_IGNORE);
  sends_.clear();
}

void MpiCrew::drop_finished_sends() {
  std::erase_if(sends_, [](Send& pending) {
    int done = 0;
    MPI_Test(&pending.request, &done, MPI_STATUS_IGNORE);
    return done != 0;
  });
}

}  // namespace sleight::coordinator
