#include "tests/attacks/campaign.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <map>
#include <thread>

#include "common/access/certificates.h"
#include "common/base/clock.h"
#include "common/rpc/client.h"
#include "tests/attacks/held_peers.h"
#include "tests/attacks/tls_acts.h"

namespace sleight::attack {
namespace {

struct Kind {
  std::string_view name;
  Door door;
  void (*act)(const Scene&);
  double share;  ///< among all attacks
  double size;   ///< approximate attacks per episode
};

// Handshakes take most of the time, so most attacks share a connection.
constexpr std::array k_kinds = std::to_array<Kind>({
    {"socket: calls", Door::socket, calls, 14, 90},
    {"socket: mutated messages", Door::socket, mutated_messages, 14, 2},
    {"socket: protocol", Door::socket, protocol_messages, 6, 1},
    {"socket: pipelined calls", Door::socket, pipelined_calls, 7, 8},
    {"socket: capabilities", Door::socket, capabilities, 5, 1},
    {"socket: pointers", Door::socket, pointers, 7, 8},
    {"socket: broken frames", Door::socket, broken_frames, 4, 1},
    {"socket: cut streams", Door::socket, cut_streams, 4, 1},
    {"socket: unread answers", Door::socket, unread_answers, 5, 150},
    {"socket: noise", Door::socket, noise, 3, 1},
    {"session: calls", Door::session, calls, 12, 90},
    {"session: mutated messages", Door::session, mutated_messages, 2, 2},
    {"session: protocol", Door::session, protocol_messages, 1, 1},
    {"session: pipelined calls", Door::session, pipelined_calls, 2, 8},
    {"session: capabilities", Door::session, capabilities, 1, 1},
    {"session: pointers", Door::session, pointers, 2, 8},
    {"session: broken frames", Door::session, broken_frames, 0.3, 1},
    {"session: cut streams", Door::session, cut_streams, 0.4, 1},
    {"session: unread answers", Door::session, unread_answers, 3, 150},
    {"session: noise", Door::session, noise, 0.3, 1},
    {"stranger: calls", Door::stranger, calls, 3, 90},
    {"stranger: mutated messages", Door::stranger, mutated_messages, 1, 2},
    {"stranger: protocol", Door::stranger, protocol_messages, 0.5, 1},
    {"stranger: pipelined calls", Door::stranger, pipelined_calls, 1, 8},
    {"stranger: capabilities", Door::stranger, capabilities, 0.5, 1},
    {"stranger: pointers", Door::stranger, pointers, 0.7, 8},
    {"stranger: broken frames", Door::stranger, broken_frames, 0.2, 1},
    {"stranger: cut streams", Door::stranger, cut_streams, 0.3, 1},
    {"stranger: unread answers", Door::stranger, unread_answers, 1, 60},
    {"stranger: noise", Door::stranger, noise, 0.2, 1},
    {"stranger: wrong tokens", Door::stranger, wrong_logins, 0.5, 1},
    {"TLS: noise", Door::stranger, tls_noise, 1, 1},
    {"TLS: mutated hellos", Door::stranger, tls_hellos, 1, 1},
    {"TLS: odd records", Door::stranger, tls_records, 1, 1},
    {"TLS: half handshakes", Door::stranger, tls_half_handshakes, 0.5, 1},
    {"TLS: after the handshake", Door::stranger, tls_after_handshakes, 0.4, 1},
});

/// Returns an episode's kind. The first episodes use each kind once; later kinds are drawn by their
/// shares.
std::size_t kind_of(std::uint64_t episode, Dice& dice) {
  if (episode < k_kinds.size()) return static_cast<std::size_t>(episode);
  double sum = 0;
  for (const Kind& kind : k_kinds)
    sum += kind.share / kind.size;
  double left = sum * dice.uniform();
  for (std::size_t i = 0; i < k_kinds.size(); ++i) {
    left -= k_kinds[i].share / k_kinds[i].size;
    if (left < 0) return i;
  }
  return k_kinds.size() - 1;
}

struct Shared {
  Shared(const Target& attacked, const Campaign& asked) : target(attacked), campaign(asked) {}

  const Target& target;
  const Campaign& campaign;
  std::array<Tally, k_kinds.size()> tallies{};
  HeldTallies held{};
  Trouble trouble{};
  std::atomic<std::uint64_t> next_episode = 0;
  std::atomic<bool> is_over = false;
  std::atomic<std::uint64_t> honest_calls = 0;
  std::atomic<double> longest_honest_s = 0;
  std::mutex mutex{};
  std::map<int, std::uint64_t> under_way{};  ///< episode by thread

  std::uint64_t attacks() const {
    std::uint64_t sum = 0;
    for (const Tally& tally : tallies)
      sum += tally.attacks;
    for (const Tally* tally :
         {&held.slow_on_socket, &held.slow_over_tls, &held.silent_on_socket, &held.silent_over_tls})
      sum += tally->attacks;
    return sum;
  }
};

void run_episode(Shared& shared, std::uint64_t episode) {
  Dice dice(shared.campaign.seed, episode);
  const std::size_t chosen = kind_of(episode, dice);
  const Kind& kind = k_kinds[chosen];
  kind.act({.target = shared.target,
            .door = kind.door,
            .episode = episode,
            .dice = dice,
            .tally = shared.tallies[chosen],
            .trouble = shared.trouble,
            .kind = kind.name});
}

void attack(Shared& shared, int thread) {
  while (!shared.trouble.is_there() && shared.attacks() < shared.campaign.count) {
    const std::uint64_t episode = shared.next_episode++;
    {
      const std::lock_guard lock(shared.mutex);
      shared.under_way[thread] = episode;
    }
    run_episode(shared, episode);
  }
}

void ask_honestly(Shared& shared, const rpc::ServicePlace& place, const char* way) {
  const base::SteadyClock clock;
  const double began_s = clock.now_s();
  try {
    rpc::Client client(place, {.call_s_max = k_honest_s_max});
    client.info();
    client.list({.count = 3});
    shared.honest_calls += 2;
  } catch (const std::exception& failure) {
    shared.trouble.say(fmt::format("an honest client {}: {}", way, failure.what()));
  }
  const double took_s = clock.now_s() - began_s;
  shared.longest_honest_s = std::max(shared.longest_honest_s.load(), took_s);
  if (took_s > k_honest_s_max) {
    shared.trouble.say(
        fmt::format("an honest client {} was answered after {:.1f} s only", way, took_s));
  }
}

void be_honest(Shared& shared) {
  const rpc::RemoteService remote{
      .address = shared.target.address,
      .token = shared.target.token,
      .certificate = shared.campaign.certificate,
      .own_name = access::self_signed_name(shared.campaign.certificate).value_or("")};
  while (!shared.is_over) {
    ask_honestly(shared, shared.target.socket, "on the socket");
    ask_honestly(shared, remote, "over TLS");
    for (int i = 0; i < 10 && !shared.is_over; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}

void count(Outcome& outcome, std::string_view name, const Tally& tally) {
  outcome.counts.push_back({.name = std::string(name),
                            .attacks = tally.attacks,
                            .reached = tally.reached,
                            .turned_away = tally.turned_away});
}

}  // namespace

Outcome run_campaign(const Target& target, const Campaign& campaign,
                     const std::function<void(const Progress&)>& tell) {
  const base::SteadyClock clock;
  const double began_s = clock.now_s();
  Shared shared(target, campaign);
  if (campaign.episode) {
    run_episode(shared, *campaign.episode);
  } else {
    std::thread honest([&] { be_honest(shared); });
    std::thread holding([&] { hold_peers(target, shared.is_over, shared.held); });
    std::vector<std::thread> attackers;
    std::atomic<int> at_work = campaign.threads;
    for (int i = 0; i < campaign.threads; ++i) {
      attackers.emplace_back([&, i] {
        attack(shared, i);
        --at_work;
      });
    }
    for (double told_s = began_s; at_work > 0;) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      if (clock.now_s() - told_s < (told_s - began_s < 10 ? 1 : 10)) continue;
      told_s = clock.now_s();
      tell({.attacks = shared.attacks(), .seconds = told_s - began_s});
    }
    for (std::thread& attacker : attackers)
      attacker.join();
    shared.is_over = true;
    honest.join();
    holding.join();
  }
  Outcome outcome{.attacks = shared.attacks(),
                  .seconds = clock.now_s() - began_s,
                  .honest_calls = shared.honest_calls,
                  .longest_honest_s = shared.longest_honest_s};
  for (std::size_t i = 0; i < k_kinds.size(); ++i)
    count(outcome, k_kinds[i].name, shared.tallies[i]);
  count(outcome, "socket: slow peers", shared.held.slow_on_socket);
  count(outcome, "TLS: slow peers", shared.held.slow_over_tls);
  count(outcome, "socket: silent peers", shared.held.silent_on_socket);
  count(outcome, "TLS: silent peers", shared.held.silent_over_tls);
  if (const auto words = shared.trouble.words()) {
    outcome.trouble = *words;
    for (const auto& [thread, episode] : shared.under_way)
      *outcome.trouble += fmt::format("\n  under way: episode {}", episode);
  }
  return outcome;
}

}  // namespace sleight::attack
