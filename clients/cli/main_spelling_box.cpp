#include "clients/cli/main_spelling_box.h"

#include "common/request/world_parameters.h"
#include "worker/worlds/spelling/parameters.h"
#include "worker/worlds/spelling/request.h"

namespace sleight::programs {

base::Result<cli::SpellingBox, std::string> read_spelling_box(std::string_view request_text) {
  const auto parameters =
      request::world_parameters(request_text, &worlds::spelling::request_binding);
  if (!parameters) return parameters.error();
  constexpr double k_mm_per_m = 1000;
  const worlds::spelling::WorldParameters& world = parameters.value().world;
  const worlds::spelling::Pattern& pattern = parameters.value().pattern;
  return cli::SpellingBox{
      .columns = pattern.columns,
      .rows = pattern.rows,
      .designated = std::vector<bool>(pattern.designated.begin(), pattern.designated.end()),
      .bin_mm = k_mm_per_m * world.bin_m,
      .partition_mm = k_mm_per_m * world.partition_m,
      .partition_height_mm = k_mm_per_m * world.partition_height_m,
      .box_height_mm = k_mm_per_m * world.box_height_m,
      .drop_height_mm = k_mm_per_m * world.drop_height_m,
      .ball_diameter_mm = k_mm_per_m * world.ball_diameter_m};
}

}  // namespace sleight::programs
