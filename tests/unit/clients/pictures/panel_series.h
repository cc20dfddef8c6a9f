// Gives tests access to the series of a drawn panel.
#pragma once

#include <variant>
#include <vector>

#include "clients/plot/figure.h"

namespace sleight::pictures {

template <class Kind>
std::vector<Kind> all_of(const plot::Panel& panel) {
  std::vector<Kind> found;
  for (const plot::Series& series : panel.series) {
    if (const auto* one = std::get_if<Kind>(&series)) found.push_back(*one);
  }
  return found;
}

}  // namespace sleight::pictures
