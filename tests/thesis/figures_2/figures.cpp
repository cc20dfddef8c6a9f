#include "tests/thesis/figures_2/figures.h"

#include <fmt/format.h>

namespace sleight::thesis {
namespace {

plot::Panel over_iterations(const Chain& chain, const std::string& y_label) {
  const auto last = static_cast<double>(chain.iterations.size() - 1);
  return {.x_label = "iteration", .y_label = y_label, .x_range = plot::Range{0, last}};
}

plot::Figure wide(const std::string& title, plot::Panel panel) {
  return {.title = title, .width_px = 860, .height_px = 320, .panels = {std::move(panel)}};
}

}  // namespace

plot::Figure filled_figure(const std::string& title, const Chain& chain) {
  plot::Panel panel = over_iterations(chain, "correct balls");
  panel.y_range = plot::Range{0, chain.balls + 0.5};
  plot::Steps steps{.width_px = 1};
  for (std::size_t i = 0; i < chain.iterations.size(); ++i)
    steps.points.push_back(
        {static_cast<double>(i), static_cast<double>(chain.iterations[i].filled)});
  panel.series.emplace_back(
      plot::HorizontalLine{.y = static_cast<double>(chain.balls), .color = plot::palette::k_grey});
  panel.series.emplace_back(std::move(steps));
  return wide(title, std::move(panel));
}

plot::Figure log_p_figure(const std::string& title, const Chain& chain,
                          const Statistics& statistics) {
  plot::Panel panel = over_iterations(chain, "log p(A)");
  for (const std::uint64_t i : statistics.change_all_effects) {
    panel.series.emplace_back(plot::VerticalLine{.x = static_cast<double>(i),
                                                 .label = "change-all effect",
                                                 .color = plot::palette::k_vermillion,
                                                 .width_px = 1});
  }
  plot::Steps steps{.label = panel.series.empty() ? "" : "log p(A)", .width_px = 1};
  for (std::size_t i = 0; i < chain.iterations.size(); ++i)
    steps.points.push_back({static_cast<double>(i), chain.iterations[i].log_p});
  panel.series.emplace_back(std::move(steps));
  return wide(title, std::move(panel));
}

std::string order_text(const worlds::spelling::Pattern& pattern,
                       const std::pair<Order, Order>& orders) {
  std::string text;
  for (std::uint32_t row = 0; row < pattern.rows; ++row) {
    // Bins are numbered from the lowest y, but rows of a pattern are numbered from the top.
    const std::size_t first_bin = std::size_t{pattern.rows - 1 - row} * pattern.columns;
    for (const Order* balls : {&orders.first, &orders.second}) {
      for (std::uint32_t column = 0; column < pattern.columns; ++column) {
        const int ball = (*balls)[first_bin + column];
        text += !pattern.at(column, row) ? "  ." : ball < 0 ? " --" : fmt::format("{:3}", ball + 1);
      }
      if (balls == &orders.first) text += "    ";
    }
    text += '\n';
  }
  return text;
}

}  // namespace sleight::thesis
