// Checks that requests are within the limits of service.h, and that this program knows all their
// values.
//
// If the request is invalid, a function returns a refusal. If the request asks for too many
// results, a function reduces their number to the maximum.
//
// Thread safety: pure functions.
#pragma once

#include <optional>
#include <vector>

#include "common/rpc/service.h"

namespace sleight::rpc {

std::optional<Refusal> check(Submission& submission);
std::optional<Refusal> check(ListAsk& ask);
std::optional<Refusal> check(ChangeAsk& ask);
std::optional<Refusal> check(LogAsk& ask);
std::optional<Refusal> check(FetchAsk& ask);
std::optional<Refusal> check(TokenAsk& ask);
std::optional<Refusal> check(const std::vector<WatchPoint>& points);

Refusal no_such_job();

}  // namespace sleight::rpc
