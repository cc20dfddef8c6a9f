// Goal: if the normalised text of a request is read, the result is the same request, and its
// normalised text is the same text. Method: write random valid requests. The keys of a request are
// in random order. Each optional key is present with probability one half. Failures print the seed.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/request/text.h"
#include "tests/support/property.h"
#include "tests/unit/common/request/toy_world.h"

namespace sleight::request {
namespace {

class Generator {
 public:
  explicit Generator(std::uint64_t seed) : state_(seed) {}

  std::uint64_t bits() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15U;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31);
  }
  std::uint64_t below(std::uint64_t end) { return bits() % end; }
  bool coin() { return below(2) == 0; }
  double unit() { return std::ldexp(static_cast<double>(bits() >> 11), -53); }  // in [0, 1)

  std::string number(double least, double most) {
    const double value = least + (most - least) * unit();
    switch (below(3)) {
      case 0:
        return toml_number(value);
      case 1:
        return fmt::format("{:.3f}", value);
      default:
        return fmt::format("{}", std::ceil(value));
    }
  }
  std::string numbers(std::size_t count) {
    std::string text = "[";
    for (std::size_t i = 0; i < count; ++i)
      text += (i == 0 ? "" : ", ") + number(0, 9);
    return text + "]";
  }

 private:
  std::uint64_t state_;
};

std::string random_section(Generator& random, std::string_view name,
                           std::vector<std::string> required, std::vector<std::string> optional) {
  std::vector<std::string> lines = std::move(required);
  for (std::string& line : optional) {
    if (random.coin()) lines.push_back(std::move(line));
  }
  for (std::size_t i = lines.size(); i > 1; --i)
    std::swap(lines[i - 1], lines[random.below(i)]);
  std::string text = fmt::format("[{}]\n", name);
  for (const std::string& line : lines)
    text += line + "\n";
  return text;
}

std::string random_request(Generator& random) {
  const auto line = [](std::string_view key, auto value) {
    return fmt::format("{} = {}", key, value);
  };
  const std::uint64_t chains = 1 + random.below(k_chains_max);
  std::vector<std::string> sections;
  sections.push_back(random_section(
      random, "world", {"name = 'toy'"},
      {line("height_m", random.number(0.001, 99)), line("tilt_deg", random.number(-90, 89)),
       line("balls", 1 + random.below(9)), line("spinning", random.coin()),
       line("surface", random.coin() ? "'felt'" : "\"wood\"")}));
  for (std::uint64_t pegs = random.below(4); pegs > 0; --pegs) {
    sections.back() +=
        random_section(random, "[world.peg]", {},
                       {line("x_m", random.number(0, 9)), line("y_m", random.number(-9, -1))});
    for (std::uint64_t rings = random.below(3); rings > 0; --rings) {
      sections.back() += random_section(random, "[world.peg.ring]", {},
                                        {line("at_m", random.numbers(2)), "surface = 'wood'"});
    }
  }
  if (random.coin()) {
    sections.back() += random_section(
        random, "world.wind", {"scale = 1", "from = 'N'", "places = ['a', \"\\u00e4\"]"},
        {line("mps", random.numbers(3)), line("gusts", random.numbers(1 + random.below(3))),
         fmt::format("path = [{},\n {}]", random.numbers(2), random.numbers(2)),
         fmt::format("triangles = [[0, 1, {}]]", random.below(10)), "name = ''",
         line("noise", fmt::format("{{sd = {}}}", random.number(0, 9)))});
  }
  sections.push_back(
      random_section(random, "constraint", {},
                     {line("word", random.coin() ? "'A\"\\'" : "\"\\u00e4\\t\""),
                      line("lambda", toml_number(std::ldexp(random.unit(), 1000)))}));
  sections.push_back(random_section(
      random, "sampler", {line("chains", chains)},
      {line("seed", random.bits() >> 1), line("iterations_per_scan", 1 + random.below(1000000)),
       line("round_scans", 1 + random.below(1000)), line("step", toml_number(random.unit()))}));
  sections.push_back(random_section(random, "stop", {line("scans", 1 + random.below(k_scans_max))},
                                    {line("rounds", 1 + random.below(29)),
                                     line("independent_solutions", 1 + random.below(chains))}));
  sections.push_back(random_section(
      random, "output", {},
      {line("thin", 1 + random.below(1000)), line("keep_max", random.below(1000001)),
       line("keep_per_lineage", random.below(1001)), line("min_distance", random.number(0, 10))}));
  std::rotate(sections.begin(), sections.begin() + static_cast<std::ptrdiff_t>(random.below(5)),
              sections.end());
  std::string text;
  for (const std::string& section : sections)
    text += section;
  return text;
}

TEST(RoundTrip, NormalisedTextReadsBackToTheSame) {
  for (const std::uint64_t seed : property::seeds(property::of_tier(300, 2000))) {
    Generator random(seed);
    const std::string text = random_request(random);
    const std::array worlds{toy::binding()};
    const auto request = read_request(text, "given.toml", worlds);
    if (!request) FAIL() << "seed " << seed << "\n" << text << to_string(request.error()[0]);

    const std::string normal = normalised_text(request.value());
    const auto reread = read_request(normal, "normal.toml", worlds);
    if (!reread) FAIL() << "seed " << seed << "\n" << normal << to_string(reread.error()[0]);
    ASSERT_EQ(reread.value(), request.value()) << "seed " << seed << "\n" << text;
    ASSERT_EQ(parameters_of<toy::Parameters>(reread.value()),
              parameters_of<toy::Parameters>(request.value()))
        << "seed " << seed << "\n"
        << text;
    ASSERT_EQ(normalised_text(reread.value()), normal) << "seed " << seed;
  }
}

}  // namespace
}  // namespace sleight::request
