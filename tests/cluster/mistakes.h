// Mistakes in distributing work. A run's digest must reveal each mistake (mutants_test.cpp).
#pragma once

#include <array>
#include <string_view>
#include <utility>

namespace sleight::cluster {

enum class Mistake {
  none,
  stale_state,         ///< a resumed replica gets the state of an earlier scan
  scan_short,          ///< a resumed replica repeats its last scan, from the state after it
  state_update_lost,   ///< the store saves the state before the last unit
  commit_dropped,      ///< a crash loses acknowledged results
  completion_order,    ///< results are attributed to the oldest assignment
  doubled_goes_on,     ///< a repeated delivery also counts as the next scans
  stale_epoch,         ///< an assignment's number counts in any epoch
  any_version,         ///< a worker resumes from any state that it holds of a replica
  own_numbers,         ///< random numbers depend on the worker
  double_swap,         ///< members of a block trade states as well as temperatures
  past_the_edge,       ///< a member continues although its partner is outside the block
  swaps_in_any_order,  ///< a swap's number is the number of swaps decided so far
};

inline constexpr std::array k_mistakes{
    std::pair{Mistake::stale_state, std::string_view("stale_state")},
    std::pair{Mistake::scan_short, std::string_view("scan_short")},
    std::pair{Mistake::state_update_lost, std::string_view("state_update_lost")},
    std::pair{Mistake::commit_dropped, std::string_view("commit_dropped")},
    std::pair{Mistake::completion_order, std::string_view("completion_order")},
    std::pair{Mistake::doubled_goes_on, std::string_view("doubled_goes_on")},
    std::pair{Mistake::stale_epoch, std::string_view("stale_epoch")},
    std::pair{Mistake::any_version, std::string_view("any_version")},
    std::pair{Mistake::own_numbers, std::string_view("own_numbers")},
    std::pair{Mistake::double_swap, std::string_view("double_swap")},
    std::pair{Mistake::past_the_edge, std::string_view("past_the_edge")},
    std::pair{Mistake::swaps_in_any_order, std::string_view("swaps_in_any_order")},
};

}  // namespace sleight::cluster
