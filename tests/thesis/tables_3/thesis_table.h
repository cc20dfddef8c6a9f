// The thesis's numbers (table_3_1.csv and table_3_2.csv). The program prints these numbers next to
// ours.
//
// A file has `#` lines that name its source, then the heading k_heading, then rows of seven
// numbers. There is a row for each number of bodies, in ascending order. A missing or invalid table
// is an error, so no column is left empty. Thread safety: pure, except for the file.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace sleight::thesis {

/// Means over the runs of one algorithm for one number of bodies.
struct Cost {
  double events = 0;
  double total_s = 0;
  double ms_per_event() const { return 1e3 * total_s / events; }
};

struct Row {
  std::uint32_t n = 0;
  Cost sync;
  Cost async;
  double collisions = 0;  ///< mean, of two bodies and with static geometry; the same for both
                          ///< algorithms; not in the thesis
  double speed_up() const { return sync.total_s / async.total_s; }
};

inline constexpr std::string_view k_heading =
    "n,sync_events,sync_ms_per_event,sync_s,async_events,async_ms_per_event,async_s";

/// Throws base::Error, which names file and line, if the file, its heading or a row is invalid, or
/// if there are no rows. In a valid row, the product of the number of events and the time per event
/// differs from the total time by at most k_rounding.
std::vector<Row> read_thesis_table(const std::string& path);

/// Throws base::Error, which names `path`, if the row is missing.
const Row& row_of(const std::vector<Row>& table, std::uint32_t n, const std::string& path);

/// Relative rounding error of the thesis's printed numbers.
inline constexpr double k_rounding = 1e-4;

}  // namespace sleight::thesis
