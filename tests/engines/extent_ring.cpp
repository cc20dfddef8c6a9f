#include "tests/engines/extent_ring.h"

namespace sleight::physics {

void ExtentRing::insert_end(std::uint64_t end) {
  // Distances from the first entry ascend (invariant 1), so binary search works.
  const auto here = std::lower_bound(
      ends_.begin(), ends_.end(), end, [this](std::uint64_t entry, std::uint64_t wanted) {
        return ahead(ends_.front(), entry) < ahead(ends_.front(), wanted);
      });
  const auto at = static_cast<std::size_t>(here - ends_.begin());
  ends_.insert(here, end);
  for (std::size_t i = at; i < ends_.size(); ++i)
    place(ends_[i]) = static_cast<std::uint32_t>(i);
}

void ExtentRing::insert(std::uint32_t body, Arc arc) {
  insert_end(end_at(arc.start, k_first, body));
  insert_end(end_at(arc.start + arc.width, k_last, body));
}

void ExtentRing::remove(std::uint32_t body) {
  for (const std::uint64_t kind : {k_first, k_last}) {
    const std::size_t at = place(kind | body);
    ends_.erase(ends_.begin() + static_cast<std::ptrdiff_t>(at));
    for (std::size_t i = at; i < ends_.size(); ++i)
      place(ends_[i]) = static_cast<std::uint32_t>(i);
  }
}

}  // namespace sleight::physics
