#include "tests/attacks/held_peers.h"

#include <chrono>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "tests/attacks/messages.h"

namespace sleight::attack {
namespace {

constexpr int k_peers_of_kind = 8;
constexpr auto k_step = std::chrono::milliseconds(3);
/// After this number of steps, a new peer replaces a silent peer. The steps take far longer than
/// the time limit of a login.
constexpr int k_silent_steps = 8000;

struct Peer {
  Tally& tally;
  bool is_over_tls;
  bool is_slow;
  std::unique_ptr<Line> line{};
  std::string to_send{};  ///< one byte per step if slow
  bool was_answered = false;
  int steps = 0;
};

void begin(const Target& target, Peer& peer, std::uint64_t number) {
  peer.steps = 0;
  peer.was_answered = false;
  peer.line =
      peer.is_over_tls ? line_to_port(target.address, number) : line_to_socket(target.socket);
  if (!peer.line) {
    ++peer.tally.turned_away;
    return;
  }
  ++peer.tally.attacks;
  if (peer.is_over_tls) {
    Tls tls(target.tls);
    tls.shake();
    peer.to_send = tls.take();
  } else {
    peer.to_send = opening();
  }
}

void step(const Target& target, Peer& peer, std::uint64_t& number) {
  if (!peer.line) return begin(target, peer, ++number);
  ++peer.steps;
  if (!peer.to_send.empty()) {
    const std::size_t bytes = peer.is_slow ? 1 : peer.to_send.size();
    const bool is_sent = peer.line->send_unread(std::string_view(peer.to_send).substr(0, bytes), 0);
    peer.to_send.erase(0, bytes);
    if (!is_sent) peer.line = nullptr;
    return;
  }
  std::string bytes;
  const Got got = peer.line->receive(bytes, 0);
  if (got == Got::bytes && !std::exchange(peer.was_answered, true)) ++peer.tally.reached;
  const bool is_done = peer.is_slow ? peer.was_answered : peer.steps > k_silent_steps;
  if (got == Got::ended || is_done) peer.line = nullptr;
}

}  // namespace

void hold_peers(const Target& target, const std::atomic<bool>& is_over, HeldTallies& tallies) {
  std::vector<Peer> peers;
  for (int i = 0; i < k_peers_of_kind; ++i) {
    peers.push_back({.tally = tallies.slow_on_socket, .is_over_tls = false, .is_slow = true});
    peers.push_back({.tally = tallies.slow_over_tls, .is_over_tls = true, .is_slow = true});
    peers.push_back({.tally = tallies.silent_on_socket, .is_over_tls = false, .is_slow = false});
    peers.push_back({.tally = tallies.silent_over_tls, .is_over_tls = true, .is_slow = false});
  }
  std::uint64_t number = 0;
  while (!is_over) {
    for (Peer& peer : peers)
      step(target, peer, number);
    std::this_thread::sleep_for(k_step);
  }
}

}  // namespace sleight::attack
