// Figures 2.8 to 2.12 as pictures and text.
//
// Thread safety: pure functions.
#pragma once

#include <string>
#include <utility>

#include "clients/plot/figure.h"
#include "tests/thesis/figures_2/chain.h"
#include "tests/thesis/figures_2/statistics.h"

namespace sleight::thesis {

/// Plots k at each iteration.
plot::Figure filled_figure(const std::string& title, const Chain& chain);

/// Plots log p(A) at each iteration. A dashed line marks the change-all effect.
plot::Figure log_p_figure(const std::string& title, const Chain& chain,
                          const Statistics& statistics);

/// Returns two orders as text, side by side and seen from above. A designated bin shows the number
/// of its ball (from 1, in the order of drops). An empty bin shows `--`.
std::string order_text(const worlds::spelling::Pattern& pattern,
                       const std::pair<Order, Order>& orders);

}  // namespace sleight::thesis
