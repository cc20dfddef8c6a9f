#include "clients/plot/decimate.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_set>

#include "clients/plot/axis.h"
#include "common/base/check.h"

namespace sleight::plot {

namespace {

// A limit far outside any device, which keeps the conversion to whole columns defined.
constexpr double k_column_far = 1e9;

std::int64_t column_of(double position, double column) {
  return static_cast<std::int64_t>(
      std::floor(std::clamp(position / column, -k_column_far, k_column_far)));
}

// Appends the first, lowest, highest and last point of a visit to a column, without duplicates, in
// their order.
void append_extremes(std::span<const Point> visit, std::vector<Point>& out) {
  const auto [low, high] = std::minmax_element(
      visit.begin(), visit.end(), [](const Point& a, const Point& b) { return a.y < b.y; });
  std::size_t kept[] = {0, static_cast<std::size_t>(low - visit.begin()),
                        static_cast<std::size_t>(high - visit.begin()), visit.size() - 1};
  std::sort(std::begin(kept), std::end(kept));
  const auto* const end = std::unique(std::begin(kept), std::end(kept));
  for (const auto* index = std::begin(kept); index != end; ++index)
    out.push_back(visit[*index]);
}

}  // namespace

std::vector<std::span<const Point>> drawable_runs(std::span<const Point> points) {
  std::vector<std::span<const Point>> runs;
  std::size_t begin = 0;
  for (std::size_t i = 0; i <= points.size(); ++i) {
    if (i < points.size() && is_drawable(points[i])) continue;
    if (i > begin) runs.push_back(points.subspan(begin, i - begin));
    begin = i + 1;
  }
  return runs;
}

std::vector<Point> decimated_line(std::span<const Point> run, double column) {
  CHECK_GT(column, 0.0);
  std::vector<Point> out;
  for (std::size_t begin = 0; begin < run.size();) {
    const std::int64_t here = column_of(run[begin].x, column);
    std::size_t end = begin + 1;
    while (end < run.size() && column_of(run[end].x, column) == here)
      ++end;
    append_extremes(run.subspan(begin, end - begin), out);
    begin = end;
  }
  return out;
}

std::vector<Point> decimated_markers(std::span<const Point> points, double cell) {
  CHECK_GT(cell, 0.0);
  std::vector<Point> out;
  std::unordered_set<std::uint64_t> taken;
  for (const Point point : points) {
    if (!is_drawable(point)) continue;
    const auto x = static_cast<std::uint64_t>(column_of(point.x, cell));
    const auto y = static_cast<std::uint64_t>(column_of(point.y, cell));
    if (taken.insert(x << 32 ^ (y & 0xFFFFFFFFU)).second) out.push_back(point);
  }
  return out;
}

std::vector<Point> stepped(std::span<const Point> points) {
  std::vector<Point> out;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i > 0 && is_drawable(points[i - 1]) && is_drawable(points[i])) {
      out.push_back({points[i].x, points[i - 1].y});
    }
    out.push_back(points[i]);
  }
  return out;
}

}  // namespace sleight::plot
