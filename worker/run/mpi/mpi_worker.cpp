#include "worker/run/mpi/mpi_worker.h"

#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "common/base/error.h"
#include "common/schema/wire/wire.h"

namespace sleight::run {
namespace {

constexpr int k_coordinator_rank = 0;
/// Growth factor of the polling interval. If a message arrives after a pause, it waits at most a
/// tenth of the pause.
constexpr double k_backoff_growth = 1.1;

/// Messages in transit to rank 0. Sending a large message doesn't wait, because waiting would
/// occupy a core that could compute.
class Outbox {
 public:
  Outbox() = default;
  Outbox(const Outbox&) = delete;
  Outbox& operator=(const Outbox&) = delete;
  ~Outbox() {
    for (Sent& sent : sent_)
      MPI_Wait(&sent.request, MPI_STATUS_IGNORE);
  }

  void send(const schema::Message& message) {
    std::erase_if(sent_, [](Sent& sent) {
      int done = 0;
      MPI_Test(&sent.request, &done, MPI_STATUS_IGNORE);
      return done != 0;
    });
    Sent& sent = sent_.emplace_back();
    sent.bytes = std::make_unique<base::Bytes>(schema::wire::encode(message));
    MPI_Isend(sent.bytes->data(), static_cast<int>(sent.bytes->size()), MPI_BYTE,
              k_coordinator_rank, schema::wire::k_message_tag, MPI_COMM_WORLD, &sent.request);
  }

 private:
  struct Sent {
    std::unique_ptr<base::Bytes> bytes;
    MPI_Request request = MPI_REQUEST_NULL;
  };
  std::vector<Sent> sent_;
};

base::Result<schema::Message, std::string> receive(const MPI_Status& status) {
  int size = 0;
  MPI_Get_count(&status, MPI_BYTE, &size);
  base::Bytes bytes(static_cast<std::size_t>(size));
  MPI_Recv(bytes.data(), size, MPI_BYTE, k_coordinator_rank, schema::wire::k_message_tag,
           MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  return schema::wire::decode(bytes);
}

/// Returns an arrived message. If no message has arrived, returns nothing or, if `waits` is set,
/// waits without occupying the core.
std::optional<base::Result<schema::Message, std::string>> next_message(bool waits) {
  double backoff_s = schema::wire::k_poll_interval_s_min;
  while (true) {
    int arrived = 0;
    MPI_Status status;
    MPI_Iprobe(k_coordinator_rank, schema::wire::k_message_tag, MPI_COMM_WORLD, &arrived, &status);
    if (arrived != 0) return receive(status);
    if (!waits) return std::nullopt;
    std::this_thread::sleep_for(std::chrono::duration<double>(backoff_s));
    backoff_s = std::min(k_backoff_growth * backoff_s, schema::wire::k_poll_interval_s_max);
  }
}

class Desk {
 public:
  Desk(const plan::BlockWorker& worker, Outbox& outbox) : worker_(worker), outbox_(outbox) {}

  /// Processes all arrived messages, then runs the oldest assignment. Returns false after a stop.
  bool turn() {
    while (std::optional message = next_message(waiting_.empty())) {
      if (!*message)
        throw base::Error(base::ExitCode::bug,
                          "invalid message from the coordinator: " + message->error());
      schema::Message value = std::move(*message).value();
      if (std::holds_alternative<schema::Stop>(value)) return false;
      if (const auto* ping = std::get_if<schema::Ping>(&value)) {
        answer(*ping);
        continue;
      }
      auto* assignment = std::get_if<schema::Assignment>(&value);
      CHECK(assignment != nullptr);
      waiting_.push_back(std::move(*assignment));
    }
    const schema::Assignment next = std::move(waiting_.front());
    waiting_.pop_front();
    outbox_.send(schema::Delivery{.epoch = next.epoch,
                                  .assignment = next.assignment,
                                  .results = worker_.run(next.block, next.states),
                                  .cache = worker_.cache_use()});
    return true;
  }

 private:
  void answer(const schema::Ping& ping) {
    schema::Pong pong{.epoch = ping.epoch, .assignments = {}};
    for (const schema::Assignment& assignment : waiting_)
      pong.assignments.push_back(assignment.assignment);
    outbox_.send(pong);
  }

  const plan::BlockWorker& worker_;
  Outbox& outbox_;
  std::deque<schema::Assignment> waiting_;  ///< Oldest first.
};

}  // namespace

void refuse(const std::string& reason) {
  Outbox().send(schema::Failure{.reason = reason});
}

void serve(const plan::BlockWorker& worker, const schema::Hello& hello) {
  Outbox outbox;
  outbox.send(hello);
  Desk desk(worker, outbox);
  while (desk.turn()) {
  }
  outbox.send(schema::Stop{});
}

}  // namespace sleight::run
