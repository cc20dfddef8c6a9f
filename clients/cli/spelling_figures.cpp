#include "clients/cli/spelling_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "clients/cli/kept_animations.h"
#include "clients/cli/request_numbers.h"
#include "clients/cli/spelling_motions.h"
#include "clients/cli/trace.h"
#include "clients/plot/layout.h"
#include "clients/plot/text.h"
#include "common/archive/summary.h"

namespace sleight::cli {
namespace {

using plot::Color;
using plot::Point;

constexpr std::size_t k_instants = 8;
constexpr std::size_t k_points_per_way = 60;
constexpr double k_figure_width_px = 1280;
constexpr double k_panel_height_max_px = 400;
constexpr double k_above_share_max = 0.6;  ///< of the width, for the view from above
constexpr double k_caption_px = 18;        ///< above a view
constexpr double k_caption_size_px = 11.5;
constexpr double k_below_px = 18;      ///< below the view from above, for a word
constexpr double k_between_px = 10;    ///< between frames
constexpr double k_beside_px = 24;     ///< between the view from above and the frames
constexpr double k_number_px_min = 7;  ///< smaller numbers can't be read

/// Around what is seen, on each side.
constexpr double k_margin_mm = 3;

constexpr Color k_partition{0xD5, 0xD5, 0xD5};
constexpr Color k_floor{0xFA, 0xFA, 0xFA};
/// Bins to be filled. No ball's colour comes near it.
constexpr Color k_tint{0xF4, 0xB8, 0xA0};
constexpr Color k_frame{0xBB, 0xBB, 0xBB};
constexpr Color k_white{0xFF, 0xFF, 0xFF};

/// The first and the last ball's colours and those between: viridis, which grows in lightness alike
/// for people with any of the common colour blindnesses and on grey prints.
constexpr std::array<std::array<double, 3>, 5> k_order_colors = {
    {{68, 1, 84}, {59, 82, 139}, {33, 145, 140}, {94, 201, 98}, {253, 231, 37}}};

/// `share` of the way from the first ball to the last.
Color order_color(double share) {
  const double at = std::clamp(share, 0.0, 1.0) * (k_order_colors.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(at), k_order_colors.size() - 2);
  const double part = at - static_cast<double>(low);
  const auto channel = [&](std::size_t i) {
    return static_cast<std::uint8_t>(
        std::lround((1 - part) * k_order_colors[low][i] + part * k_order_colors[low + 1][i]));
  };
  return {channel(0), channel(1), channel(2)};
}

/// White on dark, ink on light.
Color on_top_of(const Color& color) {
  return 0.3 * color.red + 0.59 * color.green + 0.11 * color.blue < 140 ? k_white
                                                                        : plot::palette::k_ink;
}

/// What is written along a chain.
struct IterationAxis {
  std::string label;
  double per_scan;
};

IterationAxis iteration_axis(const archive::Source& source) {
  const RequestNumbers numbers(archive::summary_of(source).request_text, source.name());
  // A search has no iterations.
  return {.label = "iteration",
          .per_scan = numbers.find("sampler", "iterations_per_scan").value_or(1)};
}

/// Half the sides of the box inside its walls, and how high a frame reaches.
struct Extent {
  double half_x_mm;
  double half_y_mm;
  double top_mm;
};

Extent extent_of(const SpellingBox& box) {
  const double pitch_mm = box.bin_mm + box.partition_mm;
  return {.half_x_mm = 0.5 * (box.columns * pitch_mm - box.partition_mm),
          .half_y_mm = 0.5 * (box.rows * pitch_mm - box.partition_mm),
          .top_mm = std::max(box.drop_height_mm + box.ball_diameter_mm, box.box_height_mm)};
}

/// The sizes of a panel's parts. A panel's own units are pixels from its lower left corner.
struct Arrangement {
  std::size_t frame_columns = k_instants;
  double frame_px_per_mm = 0.01;
  double above_px_per_mm = 0.01;
  double width_px = 0;
  double height_px = 0;
};

/// Places a plane of the box in a panel.
struct View {
  Point origin;  ///< where the box's origin is drawn
  double px_per_mm;

  Point at(double across_mm, double up_mm) const {
    return {origin.x + px_per_mm * across_mm, origin.y + px_per_mm * up_mm};
  }
};

/// Frames in so many columns, all as large as width and height allow; the view from above as high
/// as the frames together, but not wider than its share.
Arrangement arrange_in(const Extent& extent, std::size_t columns) {
  const double rows = static_cast<double>(k_instants) / static_cast<double>(columns);
  const double captions_px = rows * k_caption_px + (rows - 1) * k_between_px;
  const double above_x_mm = 2 * (extent.half_x_mm + k_margin_mm);
  const double above_y_mm = 2 * (extent.half_y_mm + k_margin_mm);
  const double frame_z_mm = extent.top_mm + 2 * k_margin_mm;
  const double frames_x_mm = static_cast<double>(columns) * above_x_mm;
  const double frames_z_mm = rows * frame_z_mm;
  const double all_px = k_figure_width_px - 2 * plot::style::k_outer;
  const double room_px = all_px - k_beside_px - static_cast<double>(columns - 1) * k_between_px;
  // Views that are equally high: ratio * (frames_z * scale + others_px) + frames_x * scale = room.
  const double ratio = above_x_mm / above_y_mm;
  const double others_px = captions_px - k_caption_px - k_below_px;
  const double equal = (room_px - ratio * others_px) / (ratio * frames_z_mm + frames_x_mm);
  const double least = (room_px - k_above_share_max * all_px) / frames_x_mm;
  const double by_height = (k_panel_height_max_px - captions_px) / frames_z_mm;
  Arrangement out{.frame_columns = columns,
                  .frame_px_per_mm = std::min(std::max(equal, least), by_height),
                  .width_px = all_px};
  out.height_px = frames_z_mm * out.frame_px_per_mm + captions_px;
  out.above_px_per_mm = std::min((out.height_px - k_caption_px - k_below_px) / above_y_mm,
                                 k_above_share_max * all_px / above_x_mm);
  return out;
}

/// As many columns of frames as let both kinds of views be large.
Arrangement arrange(const Extent& extent) {
  Arrangement best{.height_px = k_panel_height_max_px};
  for (const std::size_t columns : {8U, 4U, 2U, 1U}) {
    const Arrangement next = arrange_in(extent, columns);
    if (next.frame_px_per_mm <= 0 || next.above_px_per_mm <= 0) continue;
    if (next.frame_px_per_mm * next.above_px_per_mm > best.frame_px_per_mm * best.above_px_per_mm)
      best = next;
  }
  return best;
}

/// Adds to one panel.
class Painter {
 public:
  Painter(const SpellingBox& box, plot::Panel& panel)
      : box_(box), extent_(extent_of(box)), panel_(panel) {}

  void caption(const Point& at, std::string words, plot::Anchor anchor = plot::Anchor::start) {
    panel_.series.push_back(plot::Text{
        .at = at, .text = std::move(words), .anchor = anchor, .size_px = k_caption_size_px});
  }

  /// The box from above with the balls as they are at a time.
  void from_above(const View& view, const std::vector<BallMotion>& balls, double time_s) {
    const double pitch_mm = box_.bin_mm + box_.partition_mm;
    box(view.at(-extent_.half_x_mm, -extent_.half_y_mm),
        view.at(extent_.half_x_mm, extent_.half_y_mm), k_partition);
    for (std::uint32_t row = 0; row < box_.rows; ++row) {
      for (std::uint32_t column = 0; column < box_.columns; ++column) {
        const double left_mm = -extent_.half_x_mm + column * pitch_mm;
        const double back_mm = extent_.half_y_mm - row * pitch_mm;
        box(view.at(left_mm, back_mm - box_.bin_mm), view.at(left_mm + box_.bin_mm, back_mm),
            box_.designated[row * box_.columns + column] ? k_tint : k_floor);
      }
    }
    outline(view.at(-extent_.half_x_mm, -extent_.half_y_mm),
            view.at(extent_.half_x_mm, extent_.half_y_mm), plot::palette::k_ink, 2);
    for (const BallMotion& motion : balls) {
      if (const auto place = motion.place_at(time_s))
        ball(view.at((*place)[0], (*place)[1]), view, motion.ball());
    }
  }

  /// The box from the front at a time, balls further back behind those before them, with their ways
  /// since an earlier one.
  void from_front(const View& view, const std::vector<BallMotion>& balls, double since_s,
                  double time_s) {
    const double side_mm = extent_.half_x_mm + k_margin_mm;
    const double pitch_mm = box_.bin_mm + box_.partition_mm;
    outline(view.at(-side_mm, -k_margin_mm), view.at(side_mm, extent_.top_mm + k_margin_mm),
            k_frame, 1);
    for (std::uint32_t line = 1; line < box_.columns; ++line) {
      const double right_mm = -extent_.half_x_mm + line * pitch_mm;
      box(view.at(right_mm - box_.partition_mm, 0), view.at(right_mm, box_.partition_height_mm),
          k_partition);
    }
    for (const BallMotion& motion : balls)
      way(view, motion, since_s, time_s);
    std::vector<std::pair<PlaceMm, std::uint64_t>> seen;
    for (const BallMotion& motion : balls) {
      const auto place = motion.place_at(time_s);
      if (place && in_frame(*place)) seen.emplace_back(*place, motion.ball());
    }
    std::stable_sort(seen.begin(), seen.end(),
                     [](const auto& a, const auto& b) { return a.first[1] > b.first[1]; });
    for (const auto& [place, number] : seen)
      ball(view.at(place[0], place[2]), view, number);
    panel_.series.push_back(plot::Line{
        .points = {view.at(-extent_.half_x_mm, box_.box_height_mm), view.at(-extent_.half_x_mm, 0),
                   view.at(extent_.half_x_mm, 0), view.at(extent_.half_x_mm, box_.box_height_mm)},
        .color = plot::palette::k_ink,
        .width_px = 2});
  }

 private:
  /// What has left the box would lie upon other frames.
  bool in_frame(const PlaceMm& place) const {
    return std::abs(place[0]) <= extent_.half_x_mm + k_margin_mm && place[2] >= 0 &&
           place[2] <= extent_.top_mm;
  }
  void way(const View& view, const BallMotion& motion, double since_s, double time_s) {
    plot::Line line{.color = color_of(motion.ball()), .width_px = 1.2};
    const double from_s = std::max(since_s, motion.pieces().front().start_s);
    if (from_s >= time_s) return;
    for (std::size_t i = 0; i <= k_points_per_way; ++i) {
      const double share = static_cast<double>(i) / k_points_per_way;
      const auto place = motion.place_at(from_s + (time_s - from_s) * share);
      line.points.push_back(place && in_frame(*place) ? view.at((*place)[0], (*place)[2])
                                                      : Point{NAN, NAN});
    }
    panel_.series.push_back(std::move(line));
  }
  Color color_of(std::uint64_t number) const {
    const std::uint64_t last = std::max<std::uint64_t>(box_.designated_count(), 2) - 1;
    return order_color(static_cast<double>(number) / static_cast<double>(last));
  }
  void box(const Point& low, const Point& high, const Color& color) {
    panel_.series.push_back(plot::Rectangle{.low = low, .high = high, .color = color});
  }
  void outline(const Point& low, const Point& high, const Color& color, double width_px) {
    panel_.series.push_back(plot::Rectangle{
        .low = low, .high = high, .color = color, .filled = false, .width_px = width_px});
  }
  void ball(const Point& center, const View& view, std::uint64_t number) {
    const double radius_px = 0.5 * box_.ball_diameter_mm * view.px_per_mm;
    const Color color = color_of(number);
    panel_.series.push_back(plot::Disc{.center = center, .radius_x = radius_px, .color = color});
    panel_.series.push_back(plot::Disc{
        .center = center, .radius_x = radius_px, .color = plot::palette::k_ink, .filled = false});
    // People count from one.
    const std::string words = std::to_string(number + 1);
    const double size_px = radius_px * (words.size() < 3 ? 1.1 : 0.8);
    if (size_px < k_number_px_min) return;
    panel_.series.push_back(plot::Text{.at = center,
                                       .text = words,
                                       .anchor = plot::Anchor::middle,
                                       .color = on_top_of(color),
                                       .size_px = std::min(size_px, 22.0),
                                       .inside = true});
  }

  const SpellingBox& box_;
  Extent extent_;
  plot::Panel& panel_;
};

/// Equally spaced from the first drop until what was dropped last has bounced, then at rest.
std::array<double, k_instants> instants_of(const std::vector<BallMotion>& balls) {
  // A ball falls for an eighth of a second.
  constexpr double k_bounces_s = 0.4;
  double first_s = balls.front().pieces().front().start_s;
  double last_s = first_s;
  double rest_s = first_s;
  for (const BallMotion& motion : balls) {
    first_s = std::min(first_s, motion.pieces().front().start_s);
    last_s = std::max(last_s, motion.pieces().front().start_s);
    rest_s = std::max(rest_s, motion.pieces().back().start_s);
  }
  const double pour_s = std::min(last_s + k_bounces_s, rest_s) - first_s;
  std::array<double, k_instants> instants{};
  for (std::size_t i = 0; i < k_instants; ++i)
    instants[i] = first_s + pour_s * static_cast<double>(i) / (k_instants - 2);
  instants.back() = rest_s;
  return instants;
}

/// As much as stands above a frame without reaching the next one's.
std::string frame_caption(std::size_t instant, double time_s, double width_px) {
  const std::string time = fmt::format("{:.2f} s", time_s);
  const std::string whole = instant == 0                ? "from the front, " + time
                            : instant + 1 == k_instants ? time + ", at rest"
                                                        : time;
  return plot::text_width_px(whole, k_caption_size_px) <= width_px ? whole : time;
}

plot::Panel animation_panel(const SpellingBox& box, const std::vector<BallMotion>& balls,
                            const Arrangement& sizes) {
  const Extent extent = extent_of(box);
  plot::Panel panel{.x_range = plot::Range{0, sizes.width_px},
                    .y_range = plot::Range{0, sizes.height_px},
                    .equal_aspect = true,
                    .axes = false,
                    .legend = false};
  Painter painter(box, panel);
  const std::array<double, k_instants> instants = instants_of(balls);
  const double above_half_y_px = (extent.half_y_mm + k_margin_mm) * sizes.above_px_per_mm;
  const View above{.origin = {(extent.half_x_mm + k_margin_mm) * sizes.above_px_per_mm,
                              sizes.height_px - k_caption_px - above_half_y_px},
                   .px_per_mm = sizes.above_px_per_mm};
  const double above_width_px = 2 * above.origin.x;
  painter.caption({k_margin_mm * sizes.above_px_per_mm, sizes.height_px - k_caption_size_px},
                  "from above, at rest; tinted: bins to fill");
  painter.caption({above.origin.x, above.origin.y - above_half_y_px - k_caption_size_px}, "front",
                  plot::Anchor::middle);
  painter.from_above(above, balls, instants.back());

  const double frame_width_px = 2 * (extent.half_x_mm + k_margin_mm) * sizes.frame_px_per_mm;
  const double frame_height_px = (extent.top_mm + 2 * k_margin_mm) * sizes.frame_px_per_mm;
  for (std::size_t i = 0; i < k_instants; ++i) {
    const auto column = static_cast<double>(i % sizes.frame_columns);
    const auto row = static_cast<double>(i / sizes.frame_columns);
    const double left_px = above_width_px + k_beside_px + column * (frame_width_px + k_between_px);
    const double top_px = sizes.height_px - row * (k_caption_px + frame_height_px + k_between_px);
    painter.caption({left_px, top_px - k_caption_size_px},
                    frame_caption(i, instants[i], frame_width_px));
    const View front{
        .origin = {left_px + 0.5 * frame_width_px,
                   top_px - k_caption_px - frame_height_px + k_margin_mm * sizes.frame_px_per_mm},
        .px_per_mm = sizes.frame_px_per_mm};
    painter.from_front(front, balls, instants[i == 0 ? 0 : i - 1], instants[i]);
  }
  return panel;
}

/// The box from above alone, in millimetres.
plot::Panel above_panel(const SpellingBox& box, const std::vector<BallMotion>& balls) {
  plot::Panel panel{.x_label = "x (mm)",
                    .y_label = "y (mm)",
                    .equal_aspect = true,
                    .grid = false,
                    .legend = false};
  Painter(box, panel)
      .from_above({.origin = {0, 0}, .px_per_mm = 1}, balls, instants_of(balls).back());
  return panel;
}

}  // namespace

std::uint64_t SpellingBox::designated_count() const {
  return static_cast<std::uint64_t>(std::count(designated.begin(), designated.end(), true));
}

plot::Figure spelling_animations(const archive::Source& source, const SpellingBox& box,
                                 const SpellingAnimationOptions& options) {
  const std::vector<std::size_t> chosen = choose_animations(source, options.chain, options.count);
  const IterationAxis axis = iteration_axis(source);
  const Arrangement sizes = arrange(extent_of(box));
  plot::Figure figure{
      .title = fmt::format("Balls that spell, numbered in the order of their drops: {} animation{}",
                           chosen.size(), chosen.size() == 1 ? "" : "s"),
      .width_px = k_figure_width_px,
      .height_px = 0,
      .panels = {}};
  for (const std::size_t i : chosen) {
    const std::vector<BallMotion> balls = read_motions(source, i, box.designated_count());
    plot::Panel panel =
        options.frames ? animation_panel(box, balls, sizes) : above_panel(box, balls);
    panel.title = where_found(source, i, [&](double draw) {
      return fmt::format("{} {}", axis.label, axis.per_scan * draw);
    });
    figure.panels.push_back(std::move(panel));
    figure.height_px += sizes.height_px + plot::style::k_panel_title + 9;
  }
  figure.height_px += 2 * plot::style::k_outer + plot::style::k_figure_title + 16 +
                      plot::style::k_between_panels * static_cast<double>(chosen.size() - 1);
  return figure;
}

plot::Figure spelling_trace(const archive::Source& source, const SpellingBox& box,
                            std::optional<std::uint64_t> chain, std::uint64_t draws) {
  const IterationAxis axis = iteration_axis(source);
  const auto all = static_cast<double>(box.designated_count());
  plot::Panel filled{.title = "Designated bins that are filled",
                     .x_label = axis.label,
                     .y_label = "filled bins",
                     .y_range = plot::Range{0, all + 0.5},
                     .height_share = 1.2};
  plot::Panel log_p{.title = "log p", .x_label = axis.label, .y_label = "log p"};
  filled.series.push_back(plot::HorizontalLine{
      .y = all, .label = fmt::format("all {}", all), .color = plot::palette::k_green});
  const std::vector<std::uint64_t> chains = chains_to_draw(source, chain);
  for (std::size_t i = 0; i < chains.size(); ++i) {
    const TraceRange range{.chain = chains[i], .draws = draws};
    const auto along = [&](const char* variable, std::string label) {
      std::vector<Point> points = trace(source, variable, range, 1);
      for (Point& point : points)
        point.x *= axis.per_scan;
      return plot::Steps{.points = std::move(points),
                         .color = plot::palette::series(i),
                         .label = std::move(label),
                         .width_px = 1};
    };
    filled.series.push_back(along("filled", fmt::format("chain {}", chains[i])));
    log_p.series.push_back(along("lp", ""));
  }
  return {.title = "Balls that spell",
          .width_px = 900,
          .height_px = 560,
          .panels = {std::move(filled), std::move(log_p)}};
}

}  // namespace sleight::cli
