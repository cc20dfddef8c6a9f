#include "service/jobs/accounts.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sleight::jobs {
namespace {

constexpr double k_day_s = 86400;
constexpr double k_hour_s = 3600;

}  // namespace

void Accounts::restore(const Usage& usage) {
  of(usage.user).usage = usage;
}

Account& Accounts::of(UserId user) {
  Account& account = accounts_[user];
  account.usage.user = user;
  return account;
}

const Account* Accounts::find(UserId user) const {
  const auto found = accounts_.find(user);
  return found == accounts_.end() ? nullptr : &found->second;
}

const Limits& Accounts::limits(UserId user) const {
  const auto own = options_.limits_of.find(user);
  return own == options_.limits_of.end() ? options_.limits : own->second;
}

Usage Accounts::at(const Account& account, double now_s) const {
  Usage usage = account.usage;
  const double passed_s = std::max(0.0, now_s - usage.at_s);
  const double decay = std::exp2(-passed_s / options_.half_life_s);
  const double mean_s = options_.half_life_s / std::numbers::ln2;
  const double cores = account.cores - std::min(account.cores, account.cores_waiting);
  usage.share_core_s = usage.share_core_s * decay + cores * mean_s * (1 - decay);
  const double flows_back = limits(usage.user).core_hours_per_day * k_hour_s / k_day_s;
  usage.allowance_core_s = std::max(0.0, usage.allowance_core_s + passed_s * (cores - flows_back));
  usage.at_s = std::max(usage.at_s, now_s);
  return usage;
}

void Accounts::advance(UserId user, double now_s) {
  Account& account = of(user);
  account.usage = at(account, now_s);
}

double Accounts::had_core_s(UserId user, double now_s) const {
  const Account* account = find(user);
  return account == nullptr ? 0 : at(*account, now_s).share_core_s;
}

double Accounts::standing_core_s(UserId user, double now_s) const {
  const Account* account = find(user);
  if (account == nullptr) return 0;
  const std::uint32_t unused = account->cores_stopping + account->cores_waiting;
  const double cores = account->cores - std::min(account->cores, unused);
  return at(*account, now_s).share_core_s + cores * options_.horizon_s;
}

bool Accounts::is_over_core_hours(UserId user, double now_s, bool is_held) const {
  const double limit_core_s = limits(user).core_hours_per_day * k_hour_s;
  const Account* account = find(user);
  if (limit_core_s <= 0 || account == nullptr) return false;
  return at(*account, now_s).allowance_core_s >=
         limit_core_s * (is_held ? options_.limit_resume_factor : 1);
}

bool Accounts::is_over_bytes(UserId user, bool is_held) const {
  const std::uint64_t limit = limits(user).disk_bytes;
  const Account* account = find(user);
  if (limit == 0 || account == nullptr) return false;
  return static_cast<double>(account->disk_bytes) >=
         static_cast<double>(limit) * (is_held ? options_.limit_resume_factor : 1);
}

}  // namespace sleight::jobs
