#include "tests/attacks/listener.h"

#include <capnp/any.h>
#include <capnp/rpc.capnp.h>
#include <capnp/serialize.h>
#include <kj/exception.h>
#include <service.capnp.h>

#include <cstring>

namespace sleight::attack {
namespace {

constexpr std::size_t k_frame_bytes_max = 64U << 20U;
constexpr std::uint32_t k_segments_max = 512;

/// Returns a frame's size from its header (common/rpc/guarded_messages.cpp). 0: incomplete.
std::size_t frame_bytes(std::string_view bytes, bool& is_garbled) {
  std::uint32_t segments = 0;
  if (bytes.size() < 8) return 0;
  std::memcpy(&segments, bytes.data(), 4);
  ++segments;
  is_garbled = segments == 0 || segments > k_segments_max;
  if (is_garbled) return 0;
  const std::size_t head = (4 + std::size_t{segments} * 4 + 7) / 8 * 8;
  if (bytes.size() < head) return 0;
  std::size_t size = head;
  for (std::uint32_t i = 0; i < segments; ++i) {
    std::uint32_t words = 0;
    std::memcpy(&words, bytes.data() + 4 + std::size_t{i} * 4, 4);
    size += std::size_t{words} * 8;
  }
  is_garbled = size > k_frame_bytes_max;
  return is_garbled ? 0 : size;
}

}  // namespace

void Listener::hear(std::string_view bytes) {
  if (is_garbled_) return;
  pending_ += bytes;
  std::size_t begin = 0;
  while (true) {
    const std::string_view rest = std::string_view(pending_).substr(begin);
    const std::size_t size = frame_bytes(rest, is_garbled_);
    if (is_garbled_ || size == 0 || size > rest.size()) break;
    hear_message(rest.substr(0, size));
    begin += size;
  }
  pending_.erase(0, begin);
}

void Listener::hear_message(std::string_view frame) {
  ++messages_;
  auto words = kj::heapArray<capnp::word>(frame.size() / sizeof(capnp::word));
  std::memcpy(words.begin(), frame.data(), frame.size());
  try {
    capnp::FlatArrayMessageReader reader(words, {.traversalLimitInWords = k_frame_bytes_max});
    const auto message = reader.getRoot<capnp::rpc::Message>();
    if (message.isAbort()) ++aborts_;
    if (!message.isReturn()) return;
    const auto answer = message.getReturn();
    answered_.insert(answer.getAnswerId());
    if (answer.isException()) ++exceptions_;
    if (!answer.isResults()) return;
    resulted_.insert(answer.getAnswerId());
    const auto content = answer.getResults().getContent();
    if (!content.isStruct()) return;  // the bootstrap capability
    // In all result structs of the service, the refusal is the first pointer.
    const auto pointers = content.getAs<capnp::AnyStruct>().getPointerSection();
    if (pointers.size() == 0 || !pointers[0].isStruct()) return;
    const auto refusal = pointers[0].getAs<rpc::generated::Refusal>();
    if (refusal.getKind() == rpc::generated::Refusal::Kind::BUG) ++bugs_;
  } catch (const kj::Exception&) {
    is_garbled_ = true;
  }
}

}  // namespace sleight::attack
