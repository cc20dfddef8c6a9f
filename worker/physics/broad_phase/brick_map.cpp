#include "worker/physics/broad_phase/brick_map.h"

namespace sleight::physics {

void BrickMap::link(std::uint32_t body, CellAddress at, BodyBoxes& boxes) {
  const auto [entry, fresh] = index_.insert(at.brick);
  if (fresh) {
    if (free_.empty()) {
      entry->brick = static_cast<std::uint32_t>(bricks_.size());
      bricks_.emplace_back();
    } else {
      entry->brick = free_.back();
      free_.pop_back();
    }
    bricks_[entry->brick].key = at.brick;
    bricks_[entry->brick].mask = 0;
  }
  Brick& brick = bricks_[entry->brick];
  const std::uint64_t bit = std::uint64_t{1} << at.cell;
  boxes.coded(body).start[3] = (brick.mask & bit) != 0 ? brick.heads[at.cell] : k_nobody;
  brick.heads[at.cell] = body;
  brick.mask |= bit;
  slot_[body] = entry->brick << 6 | at.cell;
}

void BrickMap::unlink(std::uint32_t body, BodyBoxes& boxes) {
  const std::uint32_t brick_at = slot_[body] >> 6;
  const std::uint32_t cell = slot_[body] & 63;
  Brick& brick = bricks_[brick_at];
  std::uint32_t* link = &brick.heads[cell];
  while (*link != body)
    link = &boxes.coded(*link).start[3];
  *link = next(boxes.coded(body));
  if (brick.heads[cell] != k_nobody) return;
  brick.mask &= ~(std::uint64_t{1} << cell);
  if (brick.mask != 0) return;
  index_.erase(brick.key);
  free_.push_back(brick_at);
}

}  // namespace sleight::physics
