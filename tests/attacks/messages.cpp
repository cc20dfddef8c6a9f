#include "tests/attacks/messages.h"

#include <capnp/message.h>
#include <capnp/rpc.capnp.h>
#include <capnp/serialize.h>
#include <kj/exception.h>
#include <service.capnp.h>

#include <algorithm>
#include <cstring>

namespace sleight::attack {
namespace {

namespace protocol = capnp::rpc;
using generated = rpc::generated::Service;

constexpr std::uint64_t k_far_id_min = 1'000'000;

std::string frame_of(capnp::MessageBuilder& message) {
  const auto words = capnp::messageToFlatArray(message);
  const auto bytes = words.asBytes();
  return {reinterpret_cast<const char*>(bytes.begin()), bytes.size()};
}

capnp::Text::Reader text_of(const std::string& text) {
  return {text.c_str(), text.size()};
}

/// Begins a call on the promised result of question 1.
protocol::Call::Builder begin_call(capnp::MessageBuilder& message, std::uint32_t question,
                                   std::uint16_t method) {
  auto call = message.initRoot<protocol::Message>().initCall();
  call.setQuestionId(question);
  auto answer = call.initTarget().initPromisedAnswer();
  answer.setQuestionId(1);
  answer.initTransform(1)[0].setGetPointerField(1);
  call.setInterfaceId(capnp::typeId<rpc::generated::Service>());
  call.setMethodId(method);
  call.getSendResultsTo().setCaller();
  call.initParams();
  return call;
}

/// Question 0.
std::string entrance() {
  capnp::MallocMessageBuilder message;
  message.initRoot<protocol::Message>().initBootstrap().setQuestionId(0);
  return frame_of(message);
}

/// Begins question 1, a call on the result of question 0. Returns the call's parameters.
protocol::Payload::Builder begin_entering(capnp::MessageBuilder& message, std::uint16_t method) {
  auto call = message.initRoot<protocol::Message>().initCall();
  call.setQuestionId(1);
  call.initTarget().initPromisedAnswer().setQuestionId(0);
  call.setInterfaceId(capnp::typeId<rpc::generated::Entrance>());
  call.setMethodId(method);
  call.getSendResultsTo().setCaller();
  return call.initParams();
}

// --------------------------------------------------------------------------------------- protocol

std::uint32_t odd_id(Dice& dice) {
  return dice.one_in(2) ? dice.below32(6) : static_cast<std::uint32_t>(odd_number(dice));
}

/// Returns an id that usually exists. Unknown ids are rare, because they end the connection.
std::uint32_t likely_id(Dice& dice) {
  return dice.one_in(8) ? odd_id(dice) : dice.below32(2);
}

void fill_target(Dice& dice, protocol::MessageTarget::Builder to) {
  if (dice.one_in(2)) return to.setImportedCap(likely_id(dice));
  auto answer = to.initPromisedAnswer();
  answer.setQuestionId(likely_id(dice));
  auto transform = answer.initTransform(dice.one_in(20) ? 1000 : dice.below32(4));
  for (auto op : transform)
    if (dice.one_in(5)) {
      op.setNoop();
    } else {
      op.setGetPointerField(static_cast<std::uint16_t>(odd_number(dice)));
    }
}

void fill_descriptor(Dice& dice, protocol::CapDescriptor::Builder to) {
  switch (dice.below(6)) {
    case 0:
      return to.setNone();
    case 1:
      return to.setSenderHosted(odd_id(dice));
    case 2:
      return to.setSenderPromise(odd_id(dice));
    case 3:
      return to.setReceiverHosted(odd_id(dice));
    case 4: {
      auto answer = to.initReceiverAnswer();
      answer.setQuestionId(odd_id(dice));
      answer.initTransform(1)[0].setGetPointerField(static_cast<std::uint16_t>(dice.below(4)));
      return;
    }
    default:
      return to.initThirdPartyHosted().setVineId(odd_id(dice));
  }
}

void fill_exception(Dice& dice, protocol::Exception::Builder to) {
  to.setReason(text_of(odd_text(dice, 4000)));
  to.setTrace(text_of(odd_text(dice, 4000)));
  to.setType(static_cast<protocol::Exception::Type>(dice.below(6)));
}

void fill_return(Dice& dice, protocol::Return::Builder to) {
  to.setAnswerId(odd_id(dice));
  to.setReleaseParamCaps(dice.one_in(2));
  switch (dice.below(5)) {
    case 0: {
      auto results = to.initResults();
      for (auto descriptor : results.initCapTable(dice.below32(4)))
        fill_descriptor(dice, descriptor);
      return;
    }
    case 1:
      return fill_exception(dice, to.initException());
    case 2:
      return to.setCanceled();
    case 3:
      return to.setResultsSentElsewhere();
    default:
      return to.setTakeFromOtherQuestion(odd_id(dice));
  }
}

void fill_disembargo(Dice& dice, protocol::Disembargo::Builder to) {
  fill_target(dice, to.initTarget());
  auto context = to.getContext();
  switch (dice.below(4)) {
    case 0:
      return context.setSenderLoopback(odd_id(dice));
    case 1:
      return context.setReceiverLoopback(odd_id(dice));
    case 2:
      return context.setAccept();
    default:
      return context.setProvide(odd_id(dice));
  }
}

void fill_resolve(Dice& dice, protocol::Resolve::Builder to, std::uint32_t promise) {
  to.setPromiseId(promise);
  if (dice.one_in(3)) {
    fill_exception(dice, to.initException());
  } else {
    fill_descriptor(dice, to.initCap());
  }
}

/// Returns whether the message would stop or drain the service, or change a real job. Attacks by
/// the service's owner don't send such messages.
bool does_harm(const std::string& frame) {
  auto words = kj::heapArray<capnp::word>(frame.size() / sizeof(capnp::word));
  std::memcpy(words.begin(), frame.data(), words.asBytes().size());
  try {
    capnp::FlatArrayMessageReader reader(words);
    const auto message = reader.getRoot<protocol::Message>();
    if (!message.isCall()) return false;
    const auto call = message.getCall();
    const std::uint16_t method = call.getMethodId();
    if (method == drain || method == stop) return true;
    if (method != change) return false;
    const auto target =
        call.getParams().getContent().getAs<generated::ChangeParams>().getAsk().getTarget();
    const std::uint64_t id = target.isJob() ? target.getJob() : target.getGroup();
    return id > 0 && id < k_far_id_min;
  } catch (const kj::Exception&) {
    return false;  // the server can't read it either
  }
}

}  // namespace

std::string opening() {
  capnp::MallocMessageBuilder message;
  begin_entering(message, 0);
  return entrance() + frame_of(message);
}

std::string login(const std::string& token) {
  capnp::MallocMessageBuilder message;
  begin_entering(message, 1)
      .getContent()
      .initAs<rpc::generated::Entrance::LoginParams>()
      .setToken(text_of(token));
  return entrance() + frame_of(message);
}

Asked valid_call(Dice& dice, const Bounds& bounds, std::uint32_t question) {
  auto method = static_cast<Method>(dice.below(k_methods));
  if (bounds.is_owner && (method == drain || method == stop)) method = info;
  // Replace most calls of retired methods by calls of `change`. A few stay.
  if (method > logs && method < fetch && !dice.one_in(8)) method = change;
  capnp::MallocMessageBuilder message;
  auto call = begin_call(message, question, method);
  fill_parameters(dice, bounds, method, call.getParams().getContent());
  return {.frame = frame_of(message),
          .question = question,
          .may_wait = method == watch || method == fetch};
}

std::string finish(std::uint32_t question) {
  capnp::MallocMessageBuilder message;
  auto finished = message.initRoot<protocol::Message>().initFinish();
  finished.setQuestionId(question);
  finished.setReleaseResultCaps(true);
  return frame_of(message);
}

std::string odd_protocol(Dice& dice) {
  capnp::MallocMessageBuilder message;
  auto root = message.initRoot<protocol::Message>();
  switch (dice.below(11)) {
    case 0: {
      auto finished = root.initFinish();
      finished.setQuestionId(odd_id(dice));
      finished.setReleaseResultCaps(dice.one_in(2));
      break;
    }
    case 1: {
      auto released = root.initRelease();
      released.setId(odd_id(dice));
      released.setReferenceCount(static_cast<std::uint32_t>(odd_number(dice)));
      break;
    }
    case 2:
      fill_resolve(dice, root.initResolve(), odd_id(dice));
      break;
    case 3:
      fill_disembargo(dice, root.initDisembargo());
      break;
    case 4:
      fill_return(dice, root.initReturn());
      break;
    case 5:
      fill_exception(dice, root.initAbort());
      break;
    case 6: {
      // Replies "not implemented" to a message that the server may have sent.
      auto inner = root.initUnimplemented();
      if (dice.one_in(2)) {
        fill_resolve(dice, inner.initResolve(), odd_id(dice));
      } else {
        fill_return(dice, inner.initReturn());
      }
      break;
    }
    case 7:
      root.initProvide().setQuestionId(odd_id(dice));
      break;
    case 8:
      root.initAccept().setQuestionId(odd_id(dice));
      break;
    case 9:
      root.initJoin().setQuestionId(odd_id(dice));
      break;
    default:
      root.initBootstrap().setQuestionId(odd_id(dice));
      break;
  }
  return frame_of(message);
}

std::string pipelined_call(Dice& dice, std::uint32_t question) {
  capnp::MallocMessageBuilder message;
  auto call = begin_call(message, question, static_cast<std::uint16_t>(info));
  fill_target(dice, call.initTarget());
  if (dice.one_in(3)) {
    call.setInterfaceId(capnp::typeId<rpc::generated::File>());
    call.setMethodId(0);
    auto read = call.getParams().getContent().initAs<rpc::generated::File::ReadParams>();
    read.setOffset(odd_number(dice));
    read.setBytes(static_cast<std::uint32_t>(odd_number(dice)));
  } else if (dice.one_in(3)) {
    call.setInterfaceId(dice.one_in(2) ? capnp::typeId<rpc::generated::Entrance>() : dice.bits());
    call.setMethodId(static_cast<std::uint16_t>(dice.below(3)));
  } else if (dice.one_in(4)) {
    // An unknown method number.
    call.setMethodId(static_cast<std::uint16_t>(k_methods + dice.below(60'000)));
  }
  call.setAllowThirdPartyTailCall(dice.one_in(2));
  if (dice.one_in(10)) call.getSendResultsTo().setYourself();
  if (dice.one_in(10)) call.getSendResultsTo().initThirdParty();
  return frame_of(message);
}

std::vector<std::string> calls_with_capabilities(Dice& dice, std::uint32_t question) {
  std::vector<std::string> frames;
  const std::uint32_t promise = dice.below32(4);
  {
    capnp::MallocMessageBuilder message;
    // No call of the service accepts capabilities, so the server ignores them.
    auto call = begin_call(message, question, dice.one_in(2) ? info : watch);
    auto payload = call.getParams();
    auto table = payload.initCapTable(dice.one_in(50) ? 2000 : 1 + dice.below32(4));
    for (auto descriptor : table)
      fill_descriptor(dice, descriptor);
    table[0].setSenderPromise(promise);
    auto pointers = payload.getContent().initAsAnyStruct(0, 3).getPointerSection();
    if (dice.one_in(2)) pointers[0].initAsAnyStruct(1, 1);
    frames.push_back(frame_of(message));
  }
  for (std::uint64_t i = 0, count = dice.below(3); i < count; ++i) {
    capnp::MallocMessageBuilder message;
    auto root = message.initRoot<protocol::Message>();
    switch (dice.below(3)) {
      case 0: {
        // Resolves the promise to itself or to any other promise.
        auto resolved = root.initResolve();
        resolved.setPromiseId(promise);
        resolved.initCap().setSenderPromise(dice.one_in(2) ? promise : odd_id(dice));
        break;
      }
      case 1:
        fill_resolve(dice, root.initResolve(), promise);
        break;
      default:
        fill_disembargo(dice, root.initDisembargo());
        break;
    }
    frames.push_back(frame_of(message));
  }
  return frames;
}

std::string odd_pointers(Dice& dice, std::uint32_t question) {
  capnp::MallocMessageBuilder message;
  // Use only methods that neither stop the service nor change jobs, whatever their parameters are.
  constexpr std::uint16_t k_readers[] = {submit, list, status,       watch,       logs,
                                         fetch,  info, create_token, revoke_token};
  auto call = begin_call(message, question, k_readers[dice.below(std::size(k_readers))]);
  auto content = call.getParams().getContent();
  constexpr std::uint16_t k_pointers = 12;
  auto params = content.initAsAnyStruct(2, k_pointers);
  if (dice.one_in(3)) {
    auto pointer = params.getPointerSection()[0];
    for (std::uint64_t i = 0, depth = 20 + dice.below(100); i < depth; ++i)
      pointer = pointer.initAsAnyStruct(0, 1).getPointerSection()[0];
  }
  std::string frame = frame_of(message);
  // The message's last words are the pointers. Replace them at random.
  const std::size_t words = frame.size() / 8;
  for (std::size_t i = 0; i < std::min<std::size_t>(k_pointers, words - 2); ++i) {
    if (dice.one_in(3)) continue;
    std::uint64_t word = dice.bits();
    switch (dice.below(5)) {
      case 0:  // a list whose elements are all this word or a nearby one
        word = 1 | ((dice.bits() & 0xFU) << 2U) | (dice.below(8) << 32U) |
               (std::uint64_t{0x1FFFFFFF} << 35U);
        break;
      case 1:  // a struct that contains itself
        word = (std::uint64_t{0x3FFFFFFF} << 2U & 0xFFFFFFFCU) | (std::uint64_t{1} << 48U);
        break;
      case 2:  // a far pointer, possibly into a missing segment
        word = 2 | (dice.below(2) << 2U) | (dice.below(64) << 3U) | (dice.below(4) << 32U);
        break;
      case 3:  // a list of as many empty structs as possible
        word = 1 | (std::uint64_t{7} << 32U) | (dice.below(1U << 20U) << 35U);
        break;
      default:
        break;
    }
    std::memcpy(frame.data() + (words - 1 - i) * 8, &word, sizeof word);
  }
  return frame;
}

std::string mutated(Dice& dice, const Bounds& bounds, std::uint32_t question) {
  std::string frame;
  switch (dice.below(4)) {
    case 0:
      frame = odd_protocol(dice);
      break;
    case 1:
      frame = pipelined_call(dice, question);
      break;
    case 2:
      frame = calls_with_capabilities(dice, question).front();
      break;
    default:
      frame = valid_call(dice, bounds, question).frame;
      break;
  }
  const std::string before = frame;
  // Keep the header, so that the server reads the content. broken_frame() changes headers.
  for (std::uint64_t i = 0, changes = 1 + dice.below(6); i < changes; ++i) {
    const std::size_t at = 8 + dice.below(frame.size() - 8);
    frame[at] = dice.one_in(2) ? static_cast<char>(frame[at] ^ (1 << dice.below(8)))
                               : static_cast<char>(dice.bits());
  }
  return bounds.is_owner && does_harm(frame) ? before : frame;
}

std::string broken_frame(Dice& dice) {
  const auto head = [](std::initializer_list<std::uint32_t> numbers) {
    std::string bytes;
    for (const std::uint32_t number : numbers)
      bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
    return bytes;
  };
  const auto number = static_cast<std::uint32_t>(odd_number(dice));
  const std::uint32_t some = dice.below32(100);
  const std::string content = random_bytes(dice, dice.below(600));
  switch (dice.below(8)) {
    case 0:
      return head({number, static_cast<std::uint32_t>(dice.bits())}) + content;
    case 1:
      return head({0, number}) + content;
    case 2:
      return head({dice.below32(64), some, some, some}) + content;
    case 3:
      return head({1, 0x80000, 0x80000, 0}) + content;
    case 4:
      return head({0, 0});  // a message without words
    case 5:
      return head({63, 0}) + std::string(std::size_t{63} * 4 + 4, '\0');
    case 6:
      return head({0, some}) + std::string(std::size_t{some} * 8, '\xFF');
    default:
      return head({0, some}) + random_bytes(dice, std::size_t{some} * 8);
  }
}

}  // namespace sleight::attack
