#include "worker/physics/reuse/recorder.h"

namespace sleight::physics {

Recorder::Recorder(std::size_t bodies, bool records, std::size_t segments_reserved)
    : bodies_(bodies), records_(records) {
  recording_.reset(records ? bodies : 0, segments_reserved);
}

void Recorder::begin_history(std::size_t bytes_max, bool records) {
  builder_ = std::make_unique<HistoryBuilder>(bodies_, bytes_max);
  records_without_history_ = records;
  records_ = false;  // the history stores the segments
}

void Recorder::give_up_if_full() {
  if (builder_ && builder_->is_full()) give_up();
}

void Recorder::give_up() {
  if (records_without_history_) {
    recording();
    records_ = true;
  } else {
    recording_.reset(bodies_, 0);
  }
  builder_ = nullptr;
}

void Recorder::takes_over(const HistoryReader& reader, Tick last) {
  // The history contains only events that have ended.
  if (builder_ && shared_ == 0 && builder_->is_full()) give_up();
  if (!builder_) return;
  if (shared_ == 0) {
    const auto chunk = reader.whole_chunk();
    if (chunk && chunk->event(chunk->size() - 1).key.tick <= last) {
      builder_->writer().share(chunk);
      shared_ = chunk->size();
    } else {
      builder_->writer().append(reader.event());
      shared_ = 1;
    }
  }
  --shared_;
}

Recording& Recorder::recording() {
  if (builder_) recorded_ = append_to(recording_, builder_->writer().chunks(), recorded_);
  return recording_;
}

std::optional<HistoryChunks> Recorder::history() {
  give_up_if_full();
  if (!builder_) return std::nullopt;
  return builder_->writer().chunks();
}

}  // namespace sleight::physics
