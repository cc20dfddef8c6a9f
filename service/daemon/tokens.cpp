#include "service/daemon/tokens.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "common/access/token_text.h"
#include "common/base/error.h"
#include "common/base/replaced_file.h"
#include "common/json/value.h"
#include "common/logging/log.h"

namespace sleight::daemon {
namespace {

constexpr int k_format = 1;
constexpr std::size_t k_hash_characters = 64;
constexpr std::size_t k_file_bytes_max = std::size_t{64} << 20U;

rpc::Refusal wrong_token() {
  return {
      .kind = rpc::RefusalKind::not_allowed,
      .sentence = "This token is not valid here.",
      .what_to_do = "Ask the service's administrator for a new token (`sleight token create`)."};
}

json::Value json_of(const rpc::TokenView& view, const std::string& hash) {
  std::vector<std::string> scopes;
  for (const rpc::Scope scope : rpc::k_scopes)
    if (view.scopes.has(scope)) scopes.emplace_back(rpc::name_of(scope));
  return {{"cores_max", view.cores_max},
          {"created", view.created_s},
          {"expires", view.expires_s},
          {"has_expired", view.has_expired},
          {"hash", hash},
          {"id", view.id},
          {"jobs_max", view.jobs_max},
          {"last_from", view.last_from},
          {"last_used", view.last_used_s},
          {"name", view.name},
          {"revoked", view.revoked_s},
          {"scopes", scopes},
          {"user", view.user}};
}

/// Thrown if this class can't have written a value in the file.
struct Unsound {};

template <class T>
T number_in(const json::Value& json, const char* key, double most) {
  const auto& value = json.at(key);
  const bool fits = std::is_integral_v<T> ? value.is_whole() : value.is_number();
  if (!fits || !(value.get<double>() >= 0) || value.get<double>() > most) throw Unsound();
  return value.get<T>();
}

KeptToken kept_of(const json::Value& json) {
  constexpr double k_time_most = 1e12;
  constexpr double k_count_most = UINT32_MAX;
  KeptToken kept{.view = {.id = json.at("id").text(),
                          .name = json.at("name").text(),
                          .user = number_in<std::uint32_t>(json, "user", rpc::k_no_user - 1.0),
                          .created_s = number_in<double>(json, "created", k_time_most),
                          .expires_s = number_in<double>(json, "expires", k_time_most),
                          .has_expired = json.at("has_expired").get<bool>(),
                          .revoked_s = number_in<double>(json, "revoked", k_time_most),
                          .last_used_s = number_in<double>(json, "last_used", k_time_most),
                          .last_from = json.at("last_from").text(),
                          .jobs_max = number_in<std::uint32_t>(json, "jobs_max", k_count_most),
                          .cores_max = number_in<std::uint32_t>(json, "cores_max", k_count_most)},
                 .hash = json.at("hash").text()};
  for (const json::Value& name : json.at("scopes").elements()) {
    const auto scope = rpc::scope_of(name.text());
    if (!scope) throw Unsound();
    kept.view.scopes.add(*scope);
  }
  if (!access::is_token_id(kept.view.id) || kept.hash.size() != k_hash_characters) throw Unsound();
  return kept;
}

[[noreturn]] void refuse_file(const std::string& path) {
  throw base::Error(
      fmt::format("{}: damaged; restore the token file from a backup, or move it away, which makes "
                  "all tokens invalid",
                  path));
}

}  // namespace

Tokens::Tokens(base::FileSystem& files, std::string path, std::function<double()> wall_s,
               std::size_t of_user_max)
    : files_(files), path_(std::move(path)), wall_s_(std::move(wall_s)), of_user_max_(of_user_max) {
  if (files_.exists(path_)) read();
}

void Tokens::read() {
  try {
    const auto json = json::Value::parse(base::read_text_file(path_, k_file_bytes_max));
    if (json.at("format") != k_format) {
      throw base::Error(
          base::ExitCode::conflict,
          fmt::format("{}: written by another version of this program; use that version, or move "
                      "the file away, which makes all tokens invalid",
                      path_));
    }
    for (const auto& one : json.at("tokens").elements()) {
      KeptToken kept = kept_of(one);
      const std::string id = kept.view.id;
      if (!tokens_.emplace(id, std::move(kept)).second) throw Unsound();
    }
  } catch (const Unsound&) {
    refuse_file(path_);
  } catch (const json::Error&) {
    refuse_file(path_);
  }
}

/// Replaces the file atomically. The new file is durable when this function returns.
void Tokens::write() {
  is_saved_ = false;
  json::Value list = json::Value::array();
  for (const auto& [id, kept] : tokens_)
    list.push_back(json_of(kept.view, kept.hash));
  const json::Value whole{{"format", k_format}, {"tokens", std::move(list)}};
  base::replace_text_file(files_, path_, whole.dump(1) + "\n", base::Readers::owner);
  is_saved_ = true;
  has_new_uses_ = false;
}

/// Returns whether the token is valid. If the token has expired, records this.
bool Tokens::is_valid(Kept& kept) {
  rpc::TokenView& view = kept.view;
  if (!view.has_expired && view.expires_s > 0 && wall_s_() >= view.expires_s) {
    view.has_expired = true;
    is_saved_ = false;
  }
  return view.revoked_s <= 0 && !view.has_expired;
}

void Tokens::look_at_all() {
  for (auto& [id, kept] : tokens_)
    static_cast<void>(is_valid(kept));
}

base::Result<rpc::TokenView, rpc::Refusal> Tokens::create(std::uint32_t user,
                                                          const rpc::TokenAsk& ask) {
  const auto token = access::token_of(ask.token);
  if (!token) return wrong_token();
  const std::string hash = access::hash_of(*token);
  const std::uint32_t owner = ask.for_user.value_or(user);
  if (const auto known = tokens_.find(token->id); known != tokens_.end()) {
    if (known->second.view.user == owner && access::are_equal_hashes(known->second.hash, hash))
      return known->second.view;
    return rpc::Refusal{.kind = rpc::RefusalKind::conflict,
                        .sentence = "A token with this id already exists.",
                        .what_to_do = "Create a token with another id."};
  }
  const double now_s = wall_s_();
  look_at_all();
  std::erase_if(tokens_, [&](const auto& entry) {
    const rpc::TokenView& view = entry.second.view;
    const double over_s = view.revoked_s > 0 ? view.revoked_s
                          : view.has_expired ? view.expires_s
                                             : now_s;
    return now_s - over_s > k_over_token_listed_s;
  });
  const auto of_owner = std::ranges::count_if(
      tokens_, [&](const auto& entry) { return entry.second.view.user == owner; });
  if (static_cast<std::size_t>(of_owner) >= of_user_max_) {
    return rpc::Refusal{.kind = rpc::RefusalKind::limit,
                        .sentence = fmt::format("The maximum is {} tokens per user.", of_user_max_),
                        .what_to_do = "Revoked and expired tokens are deleted after 30 days."};
  }
  const rpc::TokenView view{.id = token->id,
                            .name = ask.name,
                            .user = owner,
                            .scopes = ask.scopes,
                            .created_s = now_s,
                            .expires_s = ask.valid_s > 0 ? now_s + ask.valid_s : 0,
                            .jobs_max = ask.jobs_max,
                            .cores_max = ask.cores_max};
  tokens_[token->id] = {.view = view, .hash = hash};
  try {
    write();
  } catch (...) {
    tokens_.erase(token->id);
    throw;
  }
  return view;
}

std::vector<rpc::TokenView> Tokens::of(std::optional<std::uint32_t> user) {
  std::vector<rpc::TokenView> views;
  look_at_all();
  for (const auto& [id, kept] : tokens_)
    if (!user || kept.view.user == *user) views.push_back(kept.view);
  std::ranges::stable_sort(views, std::greater(), &rpc::TokenView::created_s);
  return views;
}

base::Result<rpc::TokenView, rpc::Refusal> Tokens::revoke(std::optional<std::uint32_t> user,
                                                          const std::string& id) {
  const auto found = tokens_.find(id);
  if (found == tokens_.end() || (user && found->second.view.user != *user)) {
    return rpc::Refusal{.kind = rpc::RefusalKind::not_found,
                        .sentence = "There is no such token.",
                        .what_to_do = "`sleight token list` shows existing tokens."};
  }
  rpc::TokenView& view = found->second.view;
  // The token is revoked before the write. If the write fails, the token stays revoked.
  if (view.revoked_s > 0 && is_saved_) return view;
  if (view.revoked_s <= 0) view.revoked_s = wall_s_();
  write();
  return view;
}

base::Result<rpc::Caller, rpc::Refusal> Tokens::login(const std::string& text,
                                                      const std::string& address) {
  const auto token = access::token_of(text);
  if (!token) return wrong_token();
  const auto found = tokens_.find(token->id);
  // If the token is unknown, compare its secret with a hash that no token has. Refusing an unknown
  // token then takes as long as refusing a wrong secret.
  const std::string& kept_hash =
      found == tokens_.end() ? std::string(k_hash_characters, '-') : found->second.hash;
  const bool is_equal = access::are_equal_hashes(access::hash_of(*token), kept_hash);
  if (found == tokens_.end() || !is_equal || !is_valid(found->second)) return wrong_token();
  rpc::TokenView& view = found->second.view;
  view.last_used_s = wall_s_();
  view.last_from = address;
  has_new_uses_ = true;
  return rpc::Caller{.user = view.user,
                     .address = address,
                     .token_id = view.id,
                     .scopes = view.scopes,
                     .token_jobs_max = view.jobs_max,
                     .token_cores_max = view.cores_max};
}

bool Tokens::lets_go_on(const rpc::Caller& caller) {
  const auto found = tokens_.find(caller.token_id);
  return found != tokens_.end() && is_valid(found->second);
}

void Tokens::save_uses() {
  look_at_all();
  if (!has_new_uses_ && is_saved_) return;
  try {
    write();
  } catch (const base::Error& failure) {
    logging::warn(failure.what());
  }
}

}  // namespace sleight::daemon
