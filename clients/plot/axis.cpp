#include "clients/plot/axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/check.h"

namespace sleight::plot {

Color palette::series(std::size_t index) {
  static constexpr Color k_order[] = {k_blue, k_vermillion, k_green, k_orange, k_purple, k_sky};
  return k_order[index % std::size(k_order)];
}

namespace {

// Minimum span relative to the magnitude, for which doubles represent ten distinct ticks.
constexpr double k_relative_span_min = 1e-12;
constexpr double k_margin = 0.05;  // relative to the span, on sides that the series don't fill
// Labels have powers of ten if the exponent or the number of decimals exceeds these limits, because
// "1.5×10⁶" is then shorter than plain digits.
constexpr int k_plain_exponent_max = 5;
constexpr int k_plain_decimals_max = 5;

// A step of 1, 2 or 5 times 10^exponent.
struct Step {
  int mantissa;
  int exponent;

  // Multiplying or dividing by a power of ten gives the double nearest to the decimal.
  double times(double count) const {
    const double scaled = count * mantissa;
    return exponent >= 0 ? scaled * std::pow(10.0, exponent) : scaled / std::pow(10.0, -exponent);
  }
  Step next() const {
    if (mantissa == 1) return {2, exponent};
    if (mantissa == 2) return {5, exponent};
    return {1, exponent + 1};
  }
};

// The multiples of a step in a range; `first > last` if the range has no multiples.
struct Multiples {
  double first;
  double last;
  double count() const { return last - first + 1; }
};

Multiples multiples_in(Range range, Step step) {
  // The slack accepts 0.3 as a multiple of 0.1.
  constexpr double k_slack = 1e-9;
  const double unit = step.times(1);
  return {std::ceil(range.low / unit - k_slack), std::floor(range.high / unit + k_slack)};
}

std::string superscript(int exponent) {
  static constexpr const char* k_digits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string out = exponent < 0 ? "⁻" : "";
  for (const char digit : std::to_string(std::abs(exponent)))
    out += k_digits[digit - '0'];
  return out;
}

std::string with_minus(std::string text) {
  if (!text.starts_with('-')) return text;
  const bool is_zero = text.find_first_of("123456789") == std::string::npos;
  return fmt::format("{}{}", is_zero ? "" : "−", std::string_view(text).substr(1));
}

// All labels of an axis share one power of ten, to make them comparable.
std::vector<std::string> labels_of(const std::vector<double>& values, Step step) {
  double largest = 0;
  for (const double value : values)
    largest = std::max(largest, std::abs(value));
  const int magnitude = largest > 0 ? static_cast<int>(std::floor(std::log10(largest))) : 0;
  const bool plain = magnitude <= k_plain_exponent_max && step.exponent >= -k_plain_decimals_max;
  const int power = plain ? 0 : magnitude;
  const int decimals = std::clamp(power - step.exponent, 0, 15);
  std::vector<std::string> labels;
  for (const double value : values) {
    if (value == 0) {
      labels.emplace_back("0");
      continue;
    }
    const double scaled =
        power >= 0 ? value / std::pow(10.0, power) : value * std::pow(10.0, -power);
    labels.push_back(with_minus(fmt::format("{:.{}f}", scaled, decimals)));
    if (power != 0) labels.back() += "×10" + superscript(power);
  }
  return labels;
}

struct Extent {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void add(double value) {
    if (!(std::abs(value) < k_infinite)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  bool empty() const { return low > high; }
};

struct Extents {
  Extent x;
  Extent y;
  // A line along x may touch the panel's left and right sides, but a shape may not.
  bool x_margin = false;

  void add(Point point) {
    if (std::isnan(point.x) || std::isnan(point.y)) return;
    x.add(point.x);
    y.add(point.y);
  }

  void operator()(const Line& line) { add_all(line.points); }
  void operator()(const Steps& steps) { add_all(steps.points); }
  void operator()(const Markers& markers) {
    add_all(markers.points);
    x_margin = true;
  }
  void operator()(const HorizontalBand& band) {
    y.add(band.low);
    y.add(band.high);
  }
  void operator()(const HorizontalLine& line) { y.add(line.y); }
  void operator()(const VerticalLine& line) { x.add(line.x); }
  void operator()(const Arrow& arrow) {
    add(arrow.from);
    add(arrow.to);
    x_margin = true;
  }
  void operator()(const Disc& disc) {
    const double radius_y = disc.radius_y > 0 ? disc.radius_y : disc.radius_x;
    add({disc.center.x - disc.radius_x, disc.center.y - radius_y});
    add({disc.center.x + disc.radius_x, disc.center.y + radius_y});
    x_margin = true;
  }
  void operator()(const Rectangle& rectangle) {
    add(rectangle.low);
    add(rectangle.high);
    x_margin = true;
  }
  void operator()(const Polygon& polygon) {
    add_all(polygon.corners);
    x_margin = true;
  }
  void operator()(const Text& text) {
    add(text.at);
    x_margin = true;
  }

 private:
  void add_all(const std::vector<Point>& points) {
    for (const Point point : points)
      add(point);
  }
};

// Widens a range that is empty or too narrow for distinct ticks.
Range drawable(Range range) {
  const double magnitude = std::max(std::abs(range.low), std::abs(range.high));
  const double span_min = std::max(magnitude * k_relative_span_min, 1e-300);
  if (range.high - range.low >= span_min) return range;
  const double half = magnitude > 0 ? std::max(0.05 * magnitude, span_min) : 1;
  const double middle = range.low + (range.high - range.low) / 2;
  return {middle - half, middle + half};
}

Range range_of(const std::optional<Range>& given, const Extent& extent, bool margin) {
  if (given) {
    CHECK(std::abs(given->low) < k_infinite && std::abs(given->high) < k_infinite);
    CHECK_LT(given->low, given->high);
    return drawable(*given);
  }
  if (extent.empty()) return {0, 1};
  const Range range = drawable({extent.low, extent.high});
  if (!margin || range != Range{extent.low, extent.high}) return range;
  const double side = k_margin * (range.high - range.low);
  return {range.low - side, range.high + side};
}

}  // namespace

bool is_drawable(Point point) {
  return std::abs(point.x) < k_infinite && std::abs(point.y) < k_infinite;
}

Ticks nice_ticks(Range range, std::size_t count_max) {
  CHECK_LT(range.low, range.high);
  CHECK_GE(count_max, std::size_t{2});
  const double raw = (range.high - range.low) / static_cast<double>(count_max);
  // Start one power too fine, since log10 may round up to a whole number, then coarsen.
  Step step{1, static_cast<int>(std::floor(std::log10(raw))) - 1};
  while (multiples_in(range, step).count() > static_cast<double>(count_max))
    step = step.next();
  const Multiples multiples = multiples_in(range, step);
  Ticks ticks;
  for (double count = multiples.first; count <= multiples.last; ++count) {
    const double value = step.times(count);
    ticks.values.push_back(value == 0 ? 0 : std::clamp(value, range.low, range.high));
  }
  ticks.labels = labels_of(ticks.values, step);
  return ticks;
}

PanelRanges ranges_of(const Panel& panel) {
  Extents extents;
  for (const Series& series : panel.series)
    std::visit(extents, series);
  return {range_of(panel.x_range, extents.x, extents.x_margin || panel.equal_aspect),
          range_of(panel.y_range, extents.y, true)};
}

PanelRanges with_equal_aspect(PanelRanges ranges, double width, double height) {
  const double x_span = ranges.x.high - ranges.x.low;
  const double y_span = ranges.y.high - ranges.y.low;
  const double unit = std::max(x_span / width, y_span / height);
  const auto grown = [](Range range, double span) {
    const double more = (span - (range.high - range.low)) / 2;
    return more > 0 ? Range{range.low - more, range.high + more} : range;
  };
  return {grown(ranges.x, unit * width), grown(ranges.y, unit * height)};
}

}  // namespace sleight::plot
