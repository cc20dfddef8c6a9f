// A reader that remembers motions, so that none is simulated twice: an archive asks for each kept
// animation's motion when it chooses and when it writes, and the next archive of the run again.
//
// It changes nothing that an archive says. Not thread-safe: motions go through one memory.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/archive/forwarding_reader.h"

namespace sleight::archive {

/// Where motions are remembered, by their states. It may forget any of them.
class Motions {
 public:
  virtual ~Motions() = default;
  virtual std::optional<Motion> find(base::BytesView state) = 0;
  virtual void keep(base::BytesView state, const Motion& motion) = 0;
  /// Of the run: numbers under a name.
  virtual std::optional<std::vector<double>> find_numbers(const std::string& name) = 0;
  virtual void keep_numbers(const std::string& name, const std::vector<double>& numbers) = 0;
};

class RememberingReader final : public ForwardingReader {
 public:
  /// `before_each` is called before each motion that has to be simulated and before each animation
  /// that is to be compared; what it throws ends the work. Everything is borrowed.
  RememberingReader(const StateReader& reader, Motions& motions,
                    std::function<void()> before_each = {})
      : ForwardingReader(reader), motions_(motions), before_each_(std::move(before_each)) {}

  std::vector<double> likeness(base::BytesView state) const override {
    if (before_each_) before_each_();
    return ForwardingReader::likeness(state);
  }
  Motion play(base::BytesView state) const override {
    if (auto known = motions_.find(state)) return *std::move(known);
    if (before_each_) before_each_();
    Motion motion = ForwardingReader::play(state);
    motions_.keep(state, motion);
    return motion;
  }
  std::vector<PriorDraw> prior_draws(std::size_t count) const override {
    const std::string name = "prior draws " + std::to_string(count);
    if (const auto known = motions_.find_numbers(name)) {
      if (auto draws = draws_of(*known, count)) return *std::move(draws);
    }
    std::vector<PriorDraw> draws;
    for (std::uint64_t nth = 0; nth < count; ++nth) {
      if (before_each_) before_each_();
      draws.push_back(prior_draw(nth));
    }
    motions_.keep_numbers(name, numbers_of(draws));
    return draws;
  }

 private:
  static std::size_t width_of(const std::vector<Variable>& variables) {
    std::size_t width = 0;
    for (const Variable& variable : variables)
      width += variable.size();
    return width;
  }
  static std::vector<double> numbers_of(const std::vector<PriorDraw>& draws) {
    std::vector<double> numbers;
    for (const PriorDraw& draw : draws) {
      numbers.insert(numbers.end(),
                     {draw.log_prior, draw.log_constraint, draw.satisfied ? 1. : 0.});
      numbers.insert(numbers.end(), draw.variables.begin(), draw.variables.end());
      numbers.insert(numbers.end(), draw.outcome.begin(), draw.outcome.end());
    }
    return numbers;
  }
  /// None where they are of another size.
  std::optional<std::vector<PriorDraw>> draws_of(const std::vector<double>& numbers,
                                                 std::size_t count) const {
    const auto variables = static_cast<std::ptrdiff_t>(width_of(prior_variables(layout())));
    const auto outcomes = static_cast<std::ptrdiff_t>(width_of(layout().outcomes));
    const auto width = static_cast<std::size_t>(3 + variables + outcomes);
    if (numbers.size() != count * width) return std::nullopt;
    std::vector<PriorDraw> draws;
    for (auto at = numbers.begin(); at != numbers.end(); at += 3 + variables + outcomes)
      draws.push_back({.variables = {at + 3, at + 3 + variables},
                       .outcome = {at + 3 + variables, at + 3 + variables + outcomes},
                       .log_prior = at[0],
                       .log_constraint = at[1],
                       .satisfied = at[2] != 0});
    return draws;
  }

  Motions& motions_;
  std::function<void()> before_each_;
};

}  // namespace sleight::archive
