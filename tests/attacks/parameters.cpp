#include "tests/attacks/parameters.h"

#include <service.capnp.h>

#include <algorithm>
#include <string>

namespace sleight::attack {
namespace {

using generated = rpc::generated::Service;

capnp::Text::Reader text_of(const std::string& text) {
  return {text.c_str(), text.size()};
}

/// Returns a job id for a call that changes nothing. The job may exist.
std::uint64_t read_id(Dice& dice) {
  return dice.one_in(3) ? 1 + dice.below(3) : dice.one_in(2) ? odd_number(dice) : far_id(dice);
}

/// Returns a job id for a call that changes jobs.
std::uint64_t touch_id(Dice& dice, const Bounds& bounds) {
  return bounds.is_owner ? far_id(dice) : read_id(dice);
}

void fill_submission(Dice& dice, const Bounds& bounds, rpc::generated::Submission::Builder to) {
  to.setKey(text_of(dice.one_in(2) ? "key-" + std::to_string(dice.bits()) : odd_text(dice, 100)));
  to.setIsGroup(dice.one_in(2));
  const std::uint32_t count = dice.one_in(100) ? 1001 : dice.one_in(10) ? 0 : 1 + dice.below32(4);
  auto jobs = to.initJobs(count);
  for (std::uint32_t i = 0; i < std::min(count, 8U); ++i) {
    auto job = jobs[i];
    job.setName(text_of(odd_text(dice, 400)));
    // The first job's request is always invalid, so the whole submission is refused.
    job.setRequest(text_of(odd_request(dice, bounds.text_bytes_max)));
    job.setCores(static_cast<std::uint32_t>(odd_number(dice)));
    job.setRanks(static_cast<std::uint32_t>(odd_number(dice)));
    job.setMemoryBytes(odd_number(dice));
    job.setPriority(static_cast<std::int32_t>(odd_number(dice)));
    job.setStrict(dice.one_in(2));
    auto options = job.initOptions(dice.one_in(20) ? 40 : dice.below32(3));
    for (auto option : options) {
      option.setName(text_of(odd_text(dice, 300)));
      option.setValue(text_of(odd_text(dice, 300)));
    }
  }
}

void fill_list(Dice& dice, rpc::generated::ListAsk::Builder to) {
  if (dice.one_in(2)) to.setGroup(odd_number(dice));
  to.setUser(static_cast<std::int64_t>(odd_number(dice)));
  auto states = to.initStates(dice.one_in(50) ? 5000 : dice.below32(12));
  for (unsigned i = 0; i < states.size(); ++i)
    states.set(i, static_cast<rpc::generated::JobState>(dice.below(12)));
  to.setNamePart(text_of(odd_text(dice, 400)));
  to.setOldestFirst(dice.one_in(2));
  to.setCount(static_cast<std::uint32_t>(odd_number(dice)));
  to.setCursor(text_of(odd_text(dice, 400)));
}

void fill_watch(Dice& dice, capnp::List<rpc::generated::WatchPoint>::Builder to) {
  const bool is_doubled = dice.one_in(4);
  for (auto point : to) {
    point.setJob(is_doubled ? 1 : read_id(dice));
    point.setEvent(odd_number(dice));
    point.setChange(odd_number(dice));
    point.setMark(odd_number(dice));
  }
}

void fill_fetch(Dice& dice, rpc::generated::FetchAsk::Builder to) {
  to.setJob(read_id(dice));
  to.setKind(static_cast<rpc::generated::FetchAsk::Kind>(dice.below(7)));
  auto ids = to.initIds(dice.one_in(100) ? 10'001 : dice.below32(4));
  for (unsigned i = 0; i < ids.size(); ++i)
    ids.set(i, odd_number(dice));
  to.setAfter(text_of(odd_text(dice, 400)));
  to.setSha256Wanted(text_of(odd_text(dice, 100)));
}

void fill_token(Dice& dice, const Bounds& bounds, rpc::generated::TokenAsk::Builder to) {
  // The token has no valid checksum, so it is never created.
  to.setToken(text_of(odd_text(dice, bounds.text_bytes_max)));
  to.setName(text_of(odd_text(dice, 400)));
  to.setForUser(static_cast<std::int64_t>(odd_number(dice)));
  auto scopes = to.initScopes(dice.one_in(100) ? 5000 : dice.below32(6));
  for (unsigned i = 0; i < scopes.size(); ++i)
    scopes.set(i, static_cast<rpc::generated::Scope>(dice.below(7)));
  to.setValidFor(odd_real(dice));
  to.setJobsMax(static_cast<std::uint32_t>(odd_number(dice)));
  to.setCoresMax(static_cast<std::uint32_t>(odd_number(dice)));
}

void fill_change(Dice& dice, const Bounds& bounds, rpc::generated::ChangeAsk::Builder to) {
  const std::uint64_t id = touch_id(dice, bounds);
  auto target = to.initTarget();
  if (dice.one_in(2)) {
    target.setJob(id);
  } else {
    target.setGroup(id);
  }
  to.setKind(static_cast<rpc::generated::ChangeAsk::Kind>(dice.below(11)));
  auto extension = to.initExtension();
  extension.setBy(static_cast<rpc::generated::Extension::By>(dice.below(7)));
  extension.setTo(odd_real(dice));
  to.setPriority(static_cast<std::int32_t>(odd_number(dice)));
}

}  // namespace

void fill_parameters(Dice& dice, const Bounds& bounds, Method method,
                     capnp::AnyPointer::Builder to) {
  switch (method) {
    case submit:
      return fill_submission(dice, bounds, to.initAs<generated::SubmitParams>().initSubmission());
    case list:
      return fill_list(dice, to.initAs<generated::ListParams>().initAsk());
    case status:
      return to.initAs<generated::StatusParams>().setJob(read_id(dice));
    case watch:
      return fill_watch(dice, to.initAs<generated::WatchParams>().initPoints(
                                  dice.one_in(100) ? 1001 : dice.below32(5)));
    case logs: {
      auto ask = to.initAs<generated::LogsParams>().initAsk();
      ask.setJob(read_id(dice));
      ask.setIsTail(dice.one_in(2));
      ask.setFrom(odd_number(dice));
      ask.setLines(static_cast<std::uint32_t>(odd_number(dice)));
      return ask.setBytesMax(static_cast<std::uint32_t>(odd_number(dice)));
    }
    case change:
      return fill_change(dice, bounds, to.initAs<generated::ChangeParams>().initAsk());
    case fetch:
      return fill_fetch(dice, to.initAs<generated::FetchParams>().initAsk());
    case create_token:
      return fill_token(dice, bounds, to.initAs<generated::CreateTokenParams>().initAsk());
    case revoke_token:
      // Half of the ids have a valid form, so the service looks them up.
      return to.initAs<generated::RevokeTokenParams>().setId(
          text_of(dice.one_in(2) ? std::string(10, "0123456789abcdefgh"[dice.below(18)])
                                 : odd_text(dice, bounds.text_bytes_max)));
    case info:
    case drain:
    case stop:
    case list_tokens: {
      // These methods have no parameters. The server ignores any content.
      auto content = to.initAsAnyStruct(static_cast<std::uint16_t>(dice.below(4)),
                                        static_cast<std::uint16_t>(dice.below(4)));
      for (auto& byte : content.getDataSection())
        byte = 0xAB;
      return;
    }
  }
}

}  // namespace sleight::attack
