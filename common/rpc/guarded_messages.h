// The server's end of a connection: receives and sends messages within the limits of server.h.
//
// This class replaces Cap'n Proto's stream. Cap'n Proto's stream allocates a message before the
// message's bytes arrive. The stream stores every answer until the peer acknowledges it, and
// continues reading while answers pile up. GuardedMessages differs:
//
//   1. A message starts with its size. A message that is too large ends the connection before
//      anything is allocated. The bytes that a connection holds are counted.
//   2. Nothing is read while an answer is being written, so a peer must read its answers to be
//      served.
//   3. A connection has at most k_questions_max calls whose answers it has not released. A call
//      whose answer must go to anyone but the caller ends the connection.
//   4. A peer sends no capabilities, because no call takes one (service.capnp, law 4). Messages
//      about capabilities end the connection, because some of them make Cap'n Proto 0.9 leak the
//      connection's memory (found by tests/attacks).
//
// Thread safety: everything happens on the loop's thread.
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
inline constexpr std::size_t k_segments_max = 64;  ///< per message
inline constexpr int k_nesting_max = 32;           ///< levels of pointers

/// A connection's current state.
struct Traffic {
  std::size_t message_bytes_max = 0;  ///< smaller before login
  std::size_t incoming_bytes = 0;     ///< size of the message being received; 0: none
  kj::TimePoint incoming_since = kj::origin<kj::TimePoint>();
  std::size_t writes = 0;  ///< number of unfinished writes
  kj::TimePoint writing_since = kj::origin<kj::TimePoint>();
  kj::TimePoint active =
      kj::origin<kj::TimePoint>();  ///< when a message was last completely sent or received
};

class GuardedMessages final : public capnp::MessageStream {
 public:
  /// `grown` is called when a large message starts to be received or sent.
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
  kj::Maybe<kj::Own<kj::PromiseFulfiller<void>>>
      written_;  ///< set while a read waits for writes to finish
  std::unordered_set<std::uint32_t> questions_;
};

}  // namespace sleight::rpc
