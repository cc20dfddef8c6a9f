// What a request may hold: the limits of service.h, and values that this program knows.
//
// Each function says why a request is refused, if it is, and cuts what may be cut: counts of
// answers.
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
