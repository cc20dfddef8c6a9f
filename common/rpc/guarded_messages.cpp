#include "common/rpc/guarded_messages.h"

#include <capnp/rpc.capnp.h>
#include <kj/debug.h>

#include <utility>

namespace sleight::rpc {
namespace {

/// When a larger message is received or sent, the bytes that all connections hold are checked.
constexpr std::size_t k_large_bytes = 64U << 10U;

/// Ends the connection. The error message contains nothing that a peer sent.
kj::Exception refusal(kj::StringPtr words) {
  return {kj::Exception::Type::DISCONNECTED, __FILE__, __LINE__, kj::str(words)};
}

}  // namespace

// A message being received. A message starts with 32-bit numbers: the number of segments minus one,
// then each segment's size in words, padded to a whole word. The segments follow.
struct GuardedMessages::Incoming {
  std::uint32_t head[2] = {0, 0};         ///< number of segments minus one, size of the first
  kj::Array<std::uint32_t> more_sizes{};  ///< of the other segments, with padding
  kj::Array<capnp::word> content{};
  kj::Array<kj::ArrayPtr<const capnp::word>> segments{};
  capnp::ReaderOptions options{};
};

GuardedMessages::GuardedMessages(kj::AsyncIoStream& stream, const kj::Timer& timer,
                                 Traffic& traffic, std::function<void()> grown)
    : stream_(stream), timer_(timer), traffic_(traffic), grown_(std::move(grown)), out_(stream) {
  traffic_.active = timer_.now();
}

kj::Promise<void> GuardedMessages::when_nothing_is_written() {
  if (traffic_.writes == 0) return kj::READY_NOW;
  auto written = kj::newPromiseAndFulfiller<void>();
  written_ = kj::mv(written.fulfiller);
  return written.promise.then([this] { return when_nothing_is_written(); });
}

kj::Promise<GuardedMessages::Read> GuardedMessages::tryReadMessage(
    kj::ArrayPtr<kj::AutoCloseFd> /*descriptors*/, capnp::ReaderOptions options,
    kj::ArrayPtr<capnp::word> /*scratch*/) {
  auto incoming = kj::heap<Incoming>();
  incoming->options = options;
  auto& head = incoming->head;
  return when_nothing_is_written()
      .then([this, &head] { return stream_.tryRead(head, sizeof head, sizeof head); })
      .then([this, held = kj::mv(incoming)](std::size_t bytes) mutable -> kj::Promise<Read> {
        if (bytes == 0) return Read(nullptr);  // the peer has disconnected
        if (bytes < sizeof held->head) return refusal("a message ends inside its header");
        return read_sizes(kj::mv(held));
      });
}

kj::Promise<GuardedMessages::Read> GuardedMessages::read_sizes(kj::Own<Incoming> incoming) {
  traffic_.incoming_bytes = sizeof incoming->head;
  traffic_.incoming_since = timer_.now();
  if (incoming->head[0] >= k_segments_max) return refusal("a message has too many segments");
  const std::size_t segments = std::size_t{incoming->head[0]} + 1;
  if (segments == 1) return read_content(kj::mv(incoming));
  incoming->more_sizes = kj::heapArray<std::uint32_t>(segments / 2 * 2);
  auto& sizes = incoming->more_sizes;
  return stream_.read(sizes.begin(), sizes.asBytes().size())
      .then([this, held = kj::mv(incoming)]() mutable { return read_content(kj::mv(held)); });
}

kj::Promise<GuardedMessages::Read> GuardedMessages::read_content(kj::Own<Incoming> incoming) {
  const std::size_t segments = std::size_t{incoming->head[0]} + 1;
  const auto words_of = [&](std::size_t segment) -> std::size_t {
    return segment == 0 ? incoming->head[1] : incoming->more_sizes[segment - 1];
  };
  std::size_t words = 0;  // 64 segments of 32 bits: no overflow
  for (std::size_t i = 0; i < segments; ++i)
    words += words_of(i);
  if (words > traffic_.message_bytes_max / sizeof(capnp::word))
    return refusal("a message is too large");
  incoming->content = kj::heapArray<capnp::word>(words);
  incoming->segments = kj::heapArray<kj::ArrayPtr<const capnp::word>>(segments);
  std::size_t first = 0;
  for (std::size_t i = 0; i < segments; ++i) {
    incoming->segments[i] = incoming->content.slice(first, first + words_of(i));
    first += words_of(i);
  }
  traffic_.incoming_bytes = incoming->content.asBytes().size();
  if (traffic_.incoming_bytes > k_large_bytes) grown_();
  auto bytes = incoming->content.asBytes();
  return stream_.read(bytes.begin(), bytes.size())
      .then([this, held = kj::mv(incoming)]() mutable -> Read {
        traffic_.incoming_bytes = 0;
        traffic_.active = timer_.now();
        auto reader = kj::heap<capnp::SegmentArrayMessageReader>(held->segments, held->options);
        inspect(*reader);
        kj::Own<capnp::MessageReader> message = kj::mv(reader);
        return capnp::MessageReaderAndFds{message.attach(kj::mv(held)), nullptr};
      });
}

void GuardedMessages::inspect(capnp::MessageReader& message) {
  const auto content = message.getRoot<capnp::rpc::Message>();
  switch (content.which()) {
    case capnp::rpc::Message::CALL: {
      const auto call = content.getCall();
      if (!call.getSendResultsTo().isCaller())
        kj::throwFatalException(
            refusal("a call requests that its answer be sent to someone other than the caller"));
      if (call.getParams().getCapTable().size() > 0)
        kj::throwFatalException(refusal("a call contains capabilities"));
      questions_.insert(call.getQuestionId());
      break;
    }
    case capnp::rpc::Message::BOOTSTRAP:
      questions_.insert(content.getBootstrap().getQuestionId());
      break;
    case capnp::rpc::Message::FINISH:
      questions_.erase(content.getFinish().getQuestionId());
      break;
    case capnp::rpc::Message::RELEASE:
    case capnp::rpc::Message::ABORT:
      break;
    default:
      // All other messages are about the peer's capabilities and promises, or they answer calls of
      // the server. A client has no capabilities or promises, and the server makes no calls.
      kj::throwFatalException(refusal("clients never send messages of this kind"));
  }
  if (questions_.size() > k_questions_max) kj::throwFatalException(refusal("too many open calls"));
}

kj::Promise<void> GuardedMessages::count(kj::Promise<void> write, std::size_t bytes) {
  if (traffic_.writes++ == 0) traffic_.writing_since = timer_.now();
  if (bytes > k_large_bytes) grown_();
  return write.then([this] {
    traffic_.active = timer_.now();
    traffic_.writing_since = timer_.now();
    if (--traffic_.writes > 0) return;
    KJ_IF_MAYBE (written, written_) {
      (*written)->fulfill();
      written_ = nullptr;
    }
  });
}

kj::Promise<void> GuardedMessages::writeMessage(
    kj::ArrayPtr<const int> descriptors,
    kj::ArrayPtr<const kj::ArrayPtr<const capnp::word>> segments) {
  std::size_t bytes = 0;
  for (const auto& segment : segments)
    bytes += segment.asBytes().size();
  return count(out_.writeMessage(descriptors, segments), bytes);
}

kj::Promise<void> GuardedMessages::writeMessages(
    kj::ArrayPtr<kj::ArrayPtr<const kj::ArrayPtr<const capnp::word>>> messages) {
  return count(out_.writeMessages(messages), 0);
}

kj::Maybe<int> GuardedMessages::getSendBufferSize() {
  return out_.getSendBufferSize();
}

kj::Promise<void> GuardedMessages::end() {
  return out_.end();
}

}  // namespace sleight::rpc
