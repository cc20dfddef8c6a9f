#include "clients/pictures/trace.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "clients/analysis/archive_rows.h"
#include "common/archive/format.h"

namespace sleight::pictures {
namespace {

/// Maximum chains per panel: the palette has no more colours.
constexpr std::uint64_t k_chains_drawn_max = 6;

class Thinner {
 public:
  explicit Thinner(std::uint64_t stretch) : stretch_(stretch) {}

  void push(const plot::Point& point) {
    if (seen_ == 0) kept_.fill(point);
    ++seen_;
    kept_[k_last] = point;
    if (std::isfinite(point.y)) {
      plot::Point& lowest = kept_[k_lowest];
      plot::Point& highest = kept_[k_highest];
      if (!std::isfinite(lowest.y) || point.y < lowest.y) lowest = point;
      if (!std::isfinite(highest.y) || point.y > highest.y) highest = point;
    }
    if (seen_ == stretch_) end_stretch();
  }

  std::vector<plot::Point> take() {
    if (seen_ > 0) end_stretch();
    return std::move(points_);
  }

 private:
  static constexpr std::size_t k_lowest = 1;
  static constexpr std::size_t k_highest = 2;
  static constexpr std::size_t k_last = 3;

  void end_stretch() {
    std::ranges::sort(kept_, {}, &plot::Point::x);
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      if (i == 0 || kept_[i].x != kept_[i - 1].x) points_.push_back(kept_[i]);
    }
    seen_ = 0;
  }

  std::uint64_t stretch_;
  std::uint64_t seen_ = 0;             ///< number of points in the current stretch
  std::array<plot::Point, 4> kept_{};  ///< first, lowest, highest and last of the current stretch
  std::vector<plot::Point> points_;
};

}  // namespace

std::vector<plot::Point> trace(const archive::Source& source, std::string_view variable,
                               const TraceRange& range, double scale) {
  analysis::check_series(source, variable);
  analysis::check_chain(source, range.chain);
  const std::uint64_t draws = analysis::stats_size(source, "draw");
  const std::uint64_t count = range.draws == 0 ? draws : std::min(range.draws, draws);
  const std::uint64_t stretches = range.points_max / 4;
  Thinner thinner(count <= range.points_max ? 1 : (count - 1) / stretches + 1);
  for (std::uint64_t first = 0; first < count; first += analysis::k_batch) {
    const std::vector<double> values = analysis::as_doubles(
        source.read(archive::k_sample_stats, variable, range.chain * draws + first,
                    std::min(analysis::k_batch, count - first)));
    for (std::size_t i = 0; i < values.size(); ++i) {
      thinner.push({static_cast<double>(first + i), scale * values[i]});
    }
  }
  return thinner.take();
}

std::vector<std::uint64_t> chains_to_draw(const archive::Source& source,
                                          std::optional<std::uint64_t> asked) {
  if (asked) {
    analysis::check_chain(source, *asked);
    return {*asked};
  }
  std::vector<std::uint64_t> chains(
      std::min(analysis::stats_size(source, "chain"), k_chains_drawn_max));
  std::iota(chains.begin(), chains.end(), std::uint64_t{0});
  return chains;
}

}  // namespace sleight::pictures
