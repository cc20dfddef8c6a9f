// Of tokens: see encoding.h. Their texts are within bounds when they are kept (limits.h).
#include <algorithm>
#include <cstdint>
#include <iterator>

#include "common/rpc/encoding.h"

namespace sleight::rpc {
namespace {

constexpr generated::Scope k_wire_scopes[] = {generated::Scope::READ, generated::Scope::SUBMIT,
                                              generated::Scope::MANAGE, generated::Scope::OPERATE};

template <class Builder>
void put_scopes(const Scopes& from, Builder to) {
  unsigned count = 0;
  for (const Scope scope : k_scopes)
    count += from.has(scope) ? 1U : 0U;
  auto list = to.initScopes(count);
  unsigned place = 0;
  for (unsigned i = 0; i < std::size(k_scopes); ++i)
    if (from.has(k_scopes[i])) list.set(place++, k_wire_scopes[i]);
}

template <class Reader>
Scopes get_scopes(Reader from) {
  Scopes to;
  for (const generated::Scope scope : from.getScopes()) {
    const auto* known = std::find(std::begin(k_wire_scopes), std::end(k_wire_scopes), scope);
    if (known == std::end(k_wire_scopes)) {
      to.has_unknown = true;
    } else {
      to.add(k_scopes[known - std::begin(k_wire_scopes)]);
    }
  }
  return to;
}

}  // namespace

void put(const TokenAsk& from, generated::TokenAsk::Builder to) {
  to.setToken(as_text(from.token));
  to.setName(as_text(from.name));
  to.setForUser(from.for_user ? std::int64_t{*from.for_user} : -1);
  put_scopes(from.scopes, to);
  to.setValidFor(from.valid_s);
  to.setJobsMax(from.jobs_max);
  to.setCoresMax(from.cores_max);
}

TokenAsk get(generated::TokenAsk::Reader from) {
  TokenAsk to = {.token = as_string(from.getToken()),
                 .name = as_string(from.getName()),
                 .scopes = get_scopes(from),
                 .valid_s = from.getValidFor(),
                 .jobs_max = from.getJobsMax(),
                 .cores_max = from.getCoresMax()};
  // A number that is nobody's is not taken for the caller's own.
  if (from.getForUser() >= 0)
    to.for_user = static_cast<std::uint32_t>(std::min<std::int64_t>(from.getForUser(), UINT32_MAX));
  return to;
}

void put(const TokenView& from, generated::TokenView::Builder to) {
  to.setId(as_text(from.id));
  to.setName(as_text(from.name));
  to.setUser(from.user);
  put_scopes(from.scopes, to);
  to.setCreated(from.created_s);
  to.setExpires(from.expires_s);
  to.setExpired(from.has_expired);
  to.setRevoked(from.revoked_s);
  to.setLastUsed(from.last_used_s);
  to.setLastFrom(as_text(from.last_from));
  to.setJobsMax(from.jobs_max);
  to.setCoresMax(from.cores_max);
}

TokenView get(generated::TokenView::Reader from) {
  return {.id = as_string(from.getId()),
          .name = as_string(from.getName()),
          .user = from.getUser(),
          .scopes = get_scopes(from),
          .created_s = from.getCreated(),
          .expires_s = from.getExpires(),
          .has_expired = from.getExpired(),
          .revoked_s = from.getRevoked(),
          .last_used_s = from.getLastUsed(),
          .last_from = as_string(from.getLastFrom()),
          .jobs_max = from.getJobsMax(),
          .cores_max = from.getCoresMax()};
}

}  // namespace sleight::rpc
