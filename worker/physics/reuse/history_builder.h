// Collects the data of the event that a running simulation is processing, for its history.
//
// Internal to World. Thread safety: none.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "worker/physics/reuse/history.h"

namespace sleight::physics {

class HistoryBuilder {
 public:
  HistoryBuilder(std::size_t bodies, std::size_t bytes_max)
      : place_of_(bodies, k_nowhere), bytes_max_(bytes_max) {}

  // Data of the current event, in any order.
  void takes_part(BodyId body) { add(body, 0); }
  void begins(BodyId body) { add(body, Participant::k_begins); }
  void has_contact_state(BodyId body) { add(body, Participant::k_contact_state); }
  void touches(BodyId body, const TouchRecord& touch, bool slowly) {
    const std::size_t place =
        add(body, Participant::k_touches | (slowly ? Participant::k_slowly : 0));
    touch_of_[place] = touch;
  }
  void meet(double gap_m) { gap_m_ = gap_m; }
  void has_impact(double approach_mps, std::uint32_t noise_number) {
    approach_mps_ = approach_mps;
    noise_number_ = noise_number;
  }

  /// Ends the event. The callback state(participant, segments, touches, contact_states) appends the
  /// data that the participant's flags name. A contact state includes its touches.
  template <class State>
  void finish(const EventKey& key, const State& state) {
    segments_.clear();
    touches_.clear();
    contact_states_.clear();
    for (std::size_t i = 0; i < participants_.size(); ++i) {
      Participant& participant = participants_[i];
      place_of_[participant.body()] = k_nowhere;
      if (participant.has_contact_state())
        participant.bits &= ~(Participant::k_touches | Participant::k_slowly);
      if (participant.touches()) touches_.push_back(touch_of_[i]);
      state(participant, segments_, touches_, contact_states_);
    }
    writer_.append({.key = key,
                    .gap_m = gap_m_,
                    .approach_mps = approach_mps_,
                    .noise_number = noise_number_,
                    .participants = participants_,
                    .segments = segments_,
                    .touches = touches_,
                    .contact_states = contact_states_});
    participants_.clear();
    gap_m_ = 0;
    has_impact(0, 0);
  }
  /// After a replayed event: discards the collected data, and appends the earlier history's event.
  void replayed(const HistoryEvent& event) {
    for (const Participant& participant : participants_)
      place_of_[participant.body()] = k_nowhere;
    participants_.clear();
    writer_.append(event);
  }

  HistoryWriter& writer() { return writer_; }
  bool is_full() const { return writer_.bytes() > bytes_max_; }

 private:
  static constexpr std::uint32_t k_nowhere = std::numeric_limits<std::uint32_t>::max();
  std::size_t add(BodyId body, std::uint32_t flags) {
    std::uint32_t& place = place_of_[body];
    if (place == k_nowhere) {
      place = static_cast<std::uint32_t>(participants_.size());
      participants_.push_back({body});
      if (touch_of_.size() < participants_.size()) touch_of_.emplace_back();
    }
    participants_[place].bits |= flags;
    return place;
  }

  std::vector<std::uint32_t> place_of_;  ///< by body: index in the list of participants
  std::vector<Participant> participants_;
  std::vector<TouchRecord> touch_of_;  ///< by participant
  double gap_m_ = 0;
  double approach_mps_ = 0;
  std::uint32_t noise_number_ = 0;
  std::vector<Segment> segments_;
  std::vector<TouchRecord> touches_;
  std::vector<ContactState> contact_states_;
  HistoryWriter writer_;
  std::size_t bytes_max_;
};

}  // namespace sleight::physics
