#include "worker/physics/event/tournament_queue.h"

#include <algorithm>
#include <bit>

#include "common/base/check.h"

namespace sleight::physics {

void TournamentQueue::reset(std::uint32_t slot_count) {
  CHECK_LE(slot_count, k_slots_max);
  groups_ = std::max((slot_count + k_group - 1) / k_group, std::uint32_t{1});
  keys_.assign(std::size_t{groups_} * k_group, k_no_event);
  Group nothing{};
  nothing.fill(k_never.value);
  ticks_.assign(groups_, nothing);
  nodes_.assign(std::size_t{2} * groups_, Node{});
  for (std::uint32_t group = 0; group < groups_; ++group)
    nodes_[groups_ + group].slot = group * k_group;
  for (std::uint32_t node = groups_ - 1; node >= 1; --node)
    meet(nodes_[node] = nodes_[2 * node], nodes_[2 * node + 1]);
}

// Not inlined, so that the loops below stay small.
[[gnu::noinline]] bool TournamentQueue::loses_at_same_tick(std::uint32_t a, std::uint32_t b) const {
  const std::strong_ordering order = keys_[b] <=> keys_[a];
  return order == 0 ? b < a : order < 0;
}

inline void TournamentQueue::meet(Node& best, const Node& other) const {
  bool loses = other.tick < best.tick;
  if (other.tick == best.tick) [[unlikely]] {
    loses = loses_at_same_tick(best.slot, other.slot);
  }
  // Use masks. A choice would be compiled to a branch, and the processor can't predict this branch.
  const std::uint32_t mask = std::uint32_t{0} - static_cast<std::uint32_t>(loses);
  best.tick = std::min(best.tick, other.tick);
  best.slot ^= (best.slot ^ other.slot) & mask;
}

TournamentQueue::Node TournamentQueue::least_of(std::uint32_t group) const {
  const Group& ticks = ticks_[group];
  TickCount least = ticks[0];
  for (std::uint32_t i = 1; i < k_group; ++i)
    least = std::min(least, ticks[i]);
  std::uint32_t equal = 0;  // one bit per slot
  for (std::uint32_t i = 0; i < k_group; ++i)
    equal |= static_cast<std::uint32_t>(ticks[i] == least) << i;

  Node first{least, group * k_group + static_cast<std::uint32_t>(std::countr_zero(equal))};
  for (equal &= equal - 1; equal != 0; equal &= equal - 1)
    meet(first, {least, group * k_group + static_cast<std::uint32_t>(std::countr_zero(equal))});
  return first;
}

Slot TournamentQueue::second() const {
  // The second-best slot lost a match against the best slot: in the best slot's group, or on the
  // path up.
  const std::uint32_t first = nodes_[1].slot;
  const std::uint32_t group = first / k_group;
  Node best{};
  const auto offer = [&best](TickCount tick, std::uint32_t slot) {
    const std::uint32_t mask = std::uint32_t{0} - static_cast<std::uint32_t>(tick < best.tick);
    best.tick = std::min(best.tick, tick);
    best.slot ^= (best.slot ^ slot) & mask;
  };
  for (std::uint32_t i = 0; i < k_group; ++i) {
    const std::uint32_t slot = group * k_group + i;
    offer(slot == first ? k_never.value : ticks_[group][i], slot);
  }
  for (std::uint32_t at = groups_ + group; at > 1; at /= 2)
    offer(nodes_[at ^ 1].tick, nodes_[at ^ 1].slot);
  return {best.slot};
}

void TournamentQueue::replay(std::uint32_t group) {
  std::uint32_t at = groups_ + group;
  const std::uint32_t before = nodes_[at].slot;
  Node best = least_of(group);
  nodes_[at] = best;

  // The former overall winner had won all matches on its path.
  if (nodes_[1].slot == before) {
    for (; at > 1; at /= 2) {
      meet(best, nodes_[at ^ 1]);
      nodes_[at / 2] = best;
    }
    return;
  }

  // In other cases, the group's former winner had won its matches up to some height. Replay these
  // matches. Further up, the group's new winner meets winners from other groups until it loses. If
  // it beats a winner, it also beats the same winner at all higher nodes.
  for (; at > 1; at /= 2) {
    Node& above = nodes_[at / 2];
    if (above.slot == before) {
      meet(best, nodes_[at ^ 1]);
    } else {
      if (best.tick > above.tick) return;
      if (best.tick == above.tick && loses_at_same_tick(best.slot, above.slot)) return;
    }
    above = best;
  }
}

}  // namespace sleight::physics
