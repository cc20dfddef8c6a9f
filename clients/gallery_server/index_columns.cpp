#include "clients/gallery_server/index_columns.h"

#include <vector>

#include "clients/browse/distinct_vectors.h"
#include "clients/gallery_server/packed.h"
#include "clients/gallery_server/tables.h"
#include "common/json/value.h"

namespace sleight::gallery {
namespace {

using Json = json::Value;

void add_paths(Packed& to, const browse::Index& index) {
  std::vector<std::uint32_t> track_first;
  std::vector<std::uint32_t> track_count;
  std::vector<double> start_s;
  std::vector<double> position_m;
  std::vector<double> velocity_mps;
  std::vector<std::uint32_t> acceleration;
  browse::DistinctVectors accelerations;
  for (const browse::Entry& entry : index.entries) {
    const auto before = static_cast<std::uint32_t>(start_s.size());
    for (const browse::Track& track : entry.tracks) {
      track_first.push_back(before + track.first);
      track_count.push_back(track.count);
    }
    for (const browse::Piece& piece : entry.pieces) {
      start_s.push_back(piece.start_s);
      append(position_m, piece.position_m);
      append(velocity_mps, piece.velocity_mps);
      acceleration.push_back(accelerations.row_of(piece.acceleration_mps2));
    }
  }
  to.add("track_first", track_first);
  to.add("track_count", track_count);
  to.add("piece_start_s", start_s);
  to.add("piece_position_m", position_m);
  to.add("piece_velocity_mps", velocity_mps);
  to.add("piece_acceleration", acceleration);
  to.add("accelerations_mps2", accelerations.numbers());
}

void add_contacts(Packed& to, const browse::Index& index) {
  std::vector<std::uint32_t> first{0};
  std::vector<double> time_s;
  std::vector<std::uint32_t> body;
  std::vector<std::uint32_t> partner;
  for (const browse::Entry& entry : index.entries) {
    for (const browse::Contact& contact : entry.contacts) {
      time_s.push_back(contact.time_s);
      body.push_back(contact.body);
      partner.push_back(contact.partner);
    }
    first.push_back(static_cast<std::uint32_t>(time_s.size()));
  }
  to.add("contact_first", first);
  to.add("contact_time_s", time_s);
  to.add("contact_body", body);
  to.add("contact_partner", partner);
}

}  // namespace

std::string index_columns(const browse::Index& index, std::uint64_t generation,
                          std::span<const double> satisfied_draws) {
  Packed packed;
  add_table(packed, index);
  if (!satisfied_draws.empty()) packed.add("satisfied_draws", satisfied_draws);
  add_paths(packed, index);
  add_contacts(packed, index);
  Json names = Json::array();
  for (const browse::Entry& entry : index.entries)
    names.push_back(browse::short_text(entry.name));
  return packed.finish({{"generation", generation},
                        {"run", index.run_id},
                        {"entries", index.entries.size()},
                        {"bodies", index.scene.bodies()},
                        {"view_low_m", place_json(index.scene.low_m)},
                        {"view_high_m", place_json(index.scene.high_m)},
                        {"names", std::move(names)},
                        {"numbers", numbers_json(index)},
                        {"features", features_json(index.scene)}});
}

}  // namespace sleight::gallery
