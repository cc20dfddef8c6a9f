#include "tests/engines/calendar_queue.h"

#include <algorithm>
#include <array>
#include <bit>

#include "common/base/check.h"

namespace sleight::physics {
namespace {

/// Buckets per slot. More buckets make epochs longer. A bucket costs 4 bytes.
constexpr std::uint32_t k_buckets_per_slot = 4;
/// Number of sampled events, and how many of the earliest determine the buckets' width. Late events
/// don't matter, because they may never be processed.
constexpr std::size_t k_sample_max = 64;
constexpr std::size_t k_early_of_sample = 8;

}  // namespace

void CalendarQueue::reset(std::uint32_t slot_count) {
  CHECK_LE(slot_count, k_slots_max);
  records_.assign(slot_count, SlotRecord{});
  heap_.reset(slot_count);
  const std::uint32_t buckets = std::bit_ceil(std::max(slot_count * k_buckets_per_slot, 64U));
  heads_.assign(buckets, k_nowhere);
  occupied_.assign(buckets / 64, 0);
  current_ = 0;
  base_ = Tick{};
  shift_ = 0;
  size_ = 0;
  changes_ = 0;
}

void CalendarQueue::advance() {
  if (size_ == 0) return;
  for (std::uint64_t word = current_ / 64; word < occupied_.size(); ++word) {
    if (occupied_[word] == 0) continue;
    const auto bit = static_cast<std::uint32_t>(std::countr_zero(occupied_[word]));
    current_ = word * 64 + bit;
    occupied_[word] &= occupied_[word] - 1;
    std::uint32_t slot = heads_[current_];
    heads_[current_] = k_nowhere;
    while (slot != k_nowhere) {
      const std::uint32_t next = records_[slot].next;
      heap_.insert(records_.data(), slot);
      slot = next;
    }
    return;
  }
  begin_epoch();
}

void CalendarQueue::begin_epoch() {
  Tick earliest = k_never;
  for (const SlotRecord& record : records_)
    earliest = std::min(earliest, record.key.tick);

  // If the last epoch was too short to pay for this scan of all slots, make buckets at least four
  // times as wide as before. Otherwise use the sample's width, but shrink only in small steps.
  const std::uint32_t wanted = wanted_shift(earliest);
  const bool short_epoch = changes_ < records_.size();
  const std::uint32_t least = short_epoch ? shift_ + 2 : std::max(shift_, 1U) - 1;
  shift_ = std::min(std::max(wanted, least), 62U);
  base_ = earliest;
  current_ = 0;
  changes_ = 0;
  for (std::uint32_t slot = 0; slot < records_.size(); ++slot) {
    if (records_[slot].key != k_no_event) put_in(slot, bucket_of(records_[slot].key.tick));
  }
}

/// Returns log2 of the bucket width at which each bucket holds about one early event.
std::uint32_t CalendarQueue::wanted_shift(Tick earliest) const {
  std::array<std::uint64_t, k_sample_max> sample{};
  std::size_t count = 0;
  const std::size_t stride = std::max(records_.size() / k_sample_max, std::size_t{1});
  for (std::size_t i = 0; i < records_.size() && count < k_sample_max; i += stride) {
    if (records_[i].key.tick == k_never) continue;
    sample[count++] = static_cast<std::uint64_t>(records_[i].key.tick.value) -
                      static_cast<std::uint64_t>(earliest.value);
  }
  if (count == 0) return 0;
  const std::size_t early = std::max(count * k_early_of_sample / k_sample_max, std::size_t{1});
  std::sort(sample.begin(), sample.begin() + static_cast<std::ptrdiff_t>(count));
  const std::uint64_t span = sample[std::min(early, count - 1)];
  const std::uint64_t expected = std::max(size_ * early / count, std::size_t{1});
  return static_cast<std::uint32_t>(std::bit_width(span / expected));
}

}  // namespace sleight::physics
