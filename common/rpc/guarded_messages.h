// A server's end of a connection as messages, under the limits of server.h.
//
// Cap'n Proto's own stream gives a message's space before its bytes have come, keeps the answer to
// every question until the peer says that it has it, and reads on while answers pile up. Here:
//   1. A message says its size first; one that is too large ends the connection before it has any
//      space, and what a connection holds is counted.
//   2. Nothing is read while an answer is being written: a peer that reads none is not listened to.
//   3. A connection has at most k_questions_max questions whose answers it has not let go of. A
//      question whose answer is to be kept for others ends the connection.
//   4. A peer brings no capabilities, as no call takes one (service.capnp, law 4), and says nothing
//      of any: some of what can be said makes Cap'n Proto 0.9 keep the connection's memory for ever
//      (found by tests/attacks).
//
// Thread safety: all on the loop's thread.
#pragma once

#include <capnp/serialize-async.h>
#include <kj/async-io.h>
#include <kj/timer.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <unordered_set>

namespace sleight::rpc {

inline constexpr std::size_t k_questions_max = 64;
inline constexpr std::size_t k_segments_max = 64;  ///< of a message
inline constexpr int k_nesting_max = 32;           ///< pointers within pointers

/// What a connection does just now.
struct Traffic {
  std::size_t message_bytes_max = 0;  ///< smaller while nobody knows whose it is
  std::size_t incoming_bytes = 0;     ///< of the message that comes in; 0: none
  kj::TimePoint incoming_since = kj::origin<kj::TimePoint>();
  std::size_t writes = 0;  ///< that are not done
  kj::TimePoint writing_since = kj::origin<kj::TimePoint>();
  kj::TimePoint active = kj::origin<kj::TimePoint>();  ///< when a message last came or went whole
};

class GuardedMessages final : public capnp::MessageStream {
 public:
  /// `grown` is called when a large message begins to come in or to go out.
  GuardedMessages(kj::AsyncIoStream& stream, const kj::Timer& timer, Traffic& traffic,
                  std::function<void()> grown);

  kj::Promise<kj::Maybe<capnp::MessageReaderAndFds>> tryReadMessage(
      kj::ArrayPtr<kj::AutoCloseFd> descriptors, capnp::ReaderOptions options,
      kj::ArrayPtr<capnp::word> scratch) override;
  kj::Promise<void> writeMessage(
      kj::ArrayPtr<const int> descriptors,
      kj::ArrayPtr<const kj::ArrayPtr<const capnp::word>> segments) override;
  kj::Promise<void> writeMessages(
      kj::ArrayPtr<kj::ArrayPtr<const kj::ArrayPtr<const capnp::word>>> messages) override;
  kj::Maybe<int> getSendBufferSize() override;
  kj::Promise<void> end() override;

 private:
  using Read = kj::Maybe<capnp::MessageReaderAndFds>;
  struct Incoming;
  kj::Promise<void> when_nothing_is_written();
  kj::Promise<Read> read_sizes(kj::Own<Incoming> incoming);
  kj::Promise<Read> read_content(kj::Own<Incoming> incoming);
  void inspect(capnp::MessageReader& message);
  kj::Promise<void> count(kj::Promise<void> write, std::size_t bytes);

  kj::AsyncIoStream& stream_;
  const kj::Timer& timer_;
  Traffic& traffic_;
  std::function<void()> grown_;
  capnp::AsyncIoMessageStream out_;
  kj::Maybe<kj::Own<kj::PromiseFulfiller<void>>> written_;  ///< of a read that waits
  std::unordered_set<std::uint32_t> questions_;
};

}  // namespace sleight::rpc
