#include "service/daemon/requests.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <utility>

#include "common/hash/sha256.h"
#include "common/request/extension.h"

namespace sleight::daemon {
namespace {

StoredRequest stored_of(const request::DirectionRequest& request, bool strict) {
  return {.text = request::normalised_text(request),
          .world = request.world,
          .strict = strict,
          .found_wanted = request.stop.found.value_or(0),
          .in_proportion_wanted = request.stop.independent_solutions.value_or(0)};
}

rpc::Refusal bad_request(std::vector<request::Diagnostic> diagnostics) {
  return {.kind = rpc::RefusalKind::bad_request,
          .sentence = "The request has errors.",
          .what_to_do = "`sleight keys` lists all keys of requests.",
          .diagnostics = std::move(diagnostics)};
}

rpc::Refusal no_extension(std::string why) {
  return {.kind = rpc::RefusalKind::bad_request,
          .sentence = fmt::format("The job can't be extended: {}.", why),
          .what_to_do = "No job was changed."};
}

/// Converts within the range of the type. read_request() then checks the range of the key.
template <class Number>
std::optional<Number> whole(double value) {
  constexpr double k_most = 1e15;
  if (!(value >= 1) || value > k_most || std::floor(value) != value) return std::nullopt;
  const auto number = static_cast<std::uint64_t>(value);
  const auto narrow = static_cast<Number>(number);
  if (narrow != number) return std::nullopt;
  return narrow;
}

std::optional<request::Extension> extension_of(const rpc::Extension& extension) {
  request::Extension longer;
  switch (extension.by) {
    case rpc::ExtendBy::scans:
      longer.scans = whole<std::uint64_t>(extension.to);
      break;
    case rpc::ExtendBy::rounds:
      longer.rounds = whole<std::uint32_t>(extension.to);
      break;
    case rpc::ExtendBy::solutions:
      longer.solutions = whole<std::uint32_t>(extension.to);
      break;
    case rpc::ExtendBy::odds:
      if (std::isfinite(extension.to)) longer.odds = extension.to;
      break;
    case rpc::ExtendBy::unknown:
      break;
  }
  if (longer == request::Extension{}) return std::nullopt;
  return longer;
}

}  // namespace

base::Result<StoredRequest, rpc::Refusal> checked_request(const rpc::JobAsk& ask,
                                                          const ReadRequest& read,
                                                          const RequestLimits& limits) {
  auto request = read(ask.request, ask.name.empty() ? "request" : ask.name);
  if (!request) return bad_request(request.error());
  if (auto refused = beyond_limits(cost_of(request.value()), limits)) return *std::move(refused);
  StoredRequest stored = stored_of(request.value(), ask.strict);
  for (const rpc::JobOption& option : ask.options)
    stored.options[option.name] = option.value;
  return stored;
}

base::Result<StoredRequest, rpc::Refusal> extended_request(const StoredRequest& stored,
                                                           const rpc::Extension& extension,
                                                           const ReadRequest& read,
                                                           const RequestLimits& limits) {
  const std::string name = fmt::format("the request of job {}", stored.job.value);
  const auto asked = extension_of(extension);
  if (!asked)
    return no_extension(fmt::format("{} is not a valid number for this extension", extension.to));
  const auto request = read(stored.text, name);
  if (!request) return bad_request(request.error());
  const auto text = request::extended_text(request.value(), *asked);
  if (!text) return no_extension(text.error().why);
  const auto longer = read(text.value(), name);
  if (!longer) {
    const auto& errors = longer.error();
    return no_extension(errors.empty() ? "the request has errors" : errors.front().message);
  }
  if (auto refused = beyond_limits(cost_of(longer.value()), limits)) return *std::move(refused);
  StoredRequest next = stored_of(longer.value(), stored.strict);
  next.job = stored.job;
  next.revision = stored.revision + 1;
  next.token_id = stored.token_id;
  next.options = stored.options;
  return next;
}

std::string content_of(const rpc::JobAsk& ask, const std::string& request) {
  std::string text = fmt::format("{}\n{}\n{}\n{}\n{}\n{}\n{}", ask.name,
                                 ask.cores ? fmt::format("{}", *ask.cores) : "-", ask.ranks,
                                 ask.memory_bytes, ask.priority, ask.strict, request);
  for (const rpc::JobOption& option : ask.options)
    text += fmt::format("\n{}={}", option.name, option.value);
  return hash::sha256_hex(text);
}

}  // namespace sleight::daemon
