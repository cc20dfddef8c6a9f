// The thesis's numbers beside which ours are printed: table_3_1.csv and table_3_2.csv.
//
// A file is lines of `#` that name its source, the heading k_heading, and a row of seven numbers
// for each number of bodies, which grows. A table that is missing or reads otherwise is an error:
// no column is left empty. Thread safety: pure, but for the file.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace sleight::thesis {

/// Means over runs of one algorithm at one number of bodies: three columns of a table.
struct Cost {
  double events = 0;
  double total_s = 0;
  double ms_per_event() const { return 1e3 * total_s / events; }
};

struct Row {
  std::uint32_t n = 0;
  Cost sync;
  Cost async;
  double collisions = 0;  ///< mean, of two bodies and of static geometry, equal for both
                          ///< algorithms; the thesis doesn't tell it
  double speed_up() const { return sync.total_s / async.total_s; }
};

inline constexpr std::string_view k_heading =
    "n,sync_events,sync_ms_per_event,sync_s,async_events,async_ms_per_event,async_s";

/// Throws base::Error, with file and line, if there is no such file, its heading or a row reads
/// otherwise, events times the time of one are not the time of all to k_rounding, or it has no
/// rows.
std::vector<Row> read_thesis_table(const std::string& path);

/// The row of n bodies. Throws base::Error, with the file's `path`, if there is none.
const Row& row_of(const std::vector<Row>& table, std::uint32_t n, const std::string& path);

/// Of the thesis's printed numbers, relative.
inline constexpr double k_rounding = 1e-4;

}  // namespace sleight::thesis
