#include "worker/physics/reuse/history.h"

#include <utility>

#include "worker/physics/scene/same_bits.h"

namespace sleight::physics {
namespace {

/// Maximum events of a chunk: enough to share the part before the first difference quickly, and so
/// few that little is copied where two histories diverge.
constexpr std::size_t k_chunk_events = 256;

template <class T>
std::span<const T> part(const std::vector<T>& list, std::uint32_t from, std::uint32_t to) {
  return std::span(list).subspan(from, to - from);
}

template <class T>
void append_all(std::vector<T>& list, std::span<const T> more) {
  list.insert(list.end(), more.begin(), more.end());
}

template <class T>
std::size_t bytes_of(const std::vector<T>& list) {
  return list.capacity() * sizeof(T);
}

}  // namespace

HistoryEvent HistoryChunk::event(std::size_t index) const {
  const Entry before = index == 0 ? Entry{} : events_[index - 1];
  const Entry& own = events_[index];
  return {.key = own.key,
          .gap_m = own.gap_m,
          .approach_mps = own.approach_mps,
          .noise_number = own.noise_number,
          .participants = part(participants_, before.participants, own.participants),
          .segments = part(segments_, before.segments, own.segments),
          .touches = part(touches_, before.touches, own.touches),
          .contact_states = part(contact_states_, before.contact_states, own.contact_states)};
}

void HistoryChunk::append(const HistoryEvent& event) {
  append_all(participants_, event.participants);
  append_all(segments_, event.segments);
  append_all(touches_, event.touches);
  append_all(contact_states_, event.contact_states);
  events_.push_back({.key = event.key,
                     .gap_m = event.gap_m,
                     .approach_mps = event.approach_mps,
                     .noise_number = event.noise_number,
                     .participants = static_cast<std::uint32_t>(participants_.size()),
                     .segments = static_cast<std::uint32_t>(segments_.size()),
                     .touches = static_cast<std::uint32_t>(touches_.size()),
                     .contact_states = static_cast<std::uint32_t>(contact_states_.size())});
}

void HistoryChunk::reserve_like(const HistoryChunk& other) {
  events_.reserve(other.events_.size());
  participants_.reserve(other.participants_.size());
  segments_.reserve(other.segments_.size());
  touches_.reserve(other.touches_.size());
  contact_states_.reserve(other.contact_states_.size());
}

std::size_t HistoryChunk::bytes() const {
  return sizeof(*this) + bytes_of(events_) + bytes_of(participants_) + bytes_of(segments_) +
         bytes_of(touches_) + bytes_of(contact_states_);
}

std::size_t History::bytes() const {
  std::size_t sum = sizeof(*this) + scene.bodies.size() * sizeof(BodyDescription);
  for (const auto& chunk : chunks)
    sum += chunk->bytes();
  return sum;
}

void HistoryReader::find_event() {
  while (chunk_ < chunks_.size() && index_ == chunks_[chunk_]->size()) {
    ++chunk_;
    index_ = 0;
  }
  if (!at_end()) event_ = chunks_[chunk_]->event(index_);
}

void HistoryWriter::append(const HistoryEvent& event) {
  if (open_ && open_->size() == k_chunk_events) close();
  if (!open_) {
    open_ = std::make_shared<HistoryChunk>();
    if (!closed_.empty()) open_->reserve_like(*closed_.back());
  }
  open_->append(event);
}

void HistoryWriter::share(std::shared_ptr<const HistoryChunk> chunk) {
  close();
  closed_bytes_ += chunk->bytes();
  closed_.push_back(std::move(chunk));
}

void HistoryWriter::close() {
  if (!open_) return;
  closed_bytes_ += open_->bytes();
  closed_.push_back(std::move(open_));
  open_ = nullptr;
}

HistoryChunks HistoryWriter::chunks() {
  close();
  return closed_;
}

std::size_t append_to(Recording& recording, const HistoryChunks& chunks, std::size_t events_done) {
  std::size_t place = 0;
  for (const auto& chunk : chunks) {
    if (place + chunk->size() <= events_done) {
      place += chunk->size();
      continue;
    }
    for (std::size_t i = events_done - place; i < chunk->size(); ++i) {
      const HistoryEvent event = chunk->event(i);
      std::size_t segment = 0;
      for (const Participant& participant : event.participants) {
        if (participant.begins())
          recording.append({participant.body()}, event.segments[segment++], event.key);
      }
    }
    place += chunk->size();
    events_done = place;
  }
  return events_done;
}

bool same_bits(const TouchRecord& a, const TouchRecord& b) {
  return a.tick == b.tick && a.partner == b.partner && a.feature == b.feature &&
         same(a.friction, b.friction) && same(a.normal, b.normal) && same(a.arm_m, b.arm_m);
}

bool same_bits(const Segment& a, const Segment& b) {
  const FreeFlight& f = a.flight;
  const FreeFlight& g = b.flight;
  return a.mode == b.mode && f.begin == g.begin && same(f.position_m, g.position_m) &&
         same(f.velocity_mps, g.velocity_mps) && same(f.acceleration_mps2, g.acceleration_mps2) &&
         same(f.orientation.w(), g.orientation.w()) && same(f.orientation.x(), g.orientation.x()) &&
         same(f.orientation.y(), g.orientation.y()) && same(f.orientation.z(), g.orientation.z()) &&
         same(f.angular_velocity_radps, g.angular_velocity_radps) &&
         same(a.angular_acceleration_radps2, b.angular_acceleration_radps2);
}

}  // namespace sleight::physics
