#include "clients/plot/svg.h"

#include <glib.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/base/error.h"
#include "tests/support/numbers.h"
#include "tests/unit/clients/plot/examples.h"

namespace sleight::plot {
namespace {

// Returns GLib's error message about an XML text. Empty if the text is well-formed.
std::string xml_complaint(const std::string& text) {
  const GMarkupParser parser{};
  GMarkupParseContext* context =
      g_markup_parse_context_new(&parser, G_MARKUP_DEFAULT_FLAGS, nullptr, nullptr);
  GError* error = nullptr;
  std::string complaint;
  if (g_markup_parse_context_parse(context, text.data(), static_cast<gssize>(text.size()),
                                   &error) == FALSE ||
      g_markup_parse_context_end_parse(context, &error) == FALSE) {
    complaint = error->message;
  }
  g_clear_error(&error);
  g_markup_parse_context_free(context);
  return complaint;
}

std::size_t occurrences(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    ++count;
  return count;
}

std::string svg_of(Series series) {
  return to_svg({.panels = {Panel{.grid = false, .series = {std::move(series)}}}});
}

TEST(Svg, IsWellFormedXml) {
  // Goal: any figure is valid XML without "nan" or "inf". Method: run GLib's parser on the
  // examples, an empty figure and an empty panel. The parser must reject broken XML.
  for (const Figure& figure : {landing_figure(), paths_figure(), hostile_figure(), Figure{},
                               Figure{.panels = {Panel{}}}}) {
    const std::string svg = to_svg(figure);
    EXPECT_EQ(xml_complaint(svg), "");
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_EQ(svg.find("=\"inf"), std::string::npos);
  }
  EXPECT_NE(xml_complaint("<svg><g></svg>"), "");
}

TEST(Svg, EscapesWhatPeopleWrite) {
  // Goal: labels can't become markup. Method: put markup into every text.
  const std::string evil = "</text><script>x</script>&\"'";
  const Panel panel{.title = evil,
                    .x_label = evil,
                    .y_label = evil,
                    .series = {Line{.label = evil}, Text{.text = evil}}};
  const std::string svg = to_svg({.title = evil, .panels = {panel}});
  EXPECT_EQ(svg.find("<script"), std::string::npos);
  EXPECT_EQ(xml_complaint(svg), "");
}

TEST(Svg, SaysWhereItComesFrom) {
  // Goal: notes appear in the metadata, escaped, one per line, and change nothing else. Method:
  // compare a hostile figure with and without notes, after cutting out the metadata.
  const Notes notes =
      notes_of(std::vector<std::string>{"command=draw </metadata> & more", "seed=7"});
  const std::string svg = to_svg(hostile_figure(), notes);
  EXPECT_EQ(xml_complaint(svg), "");
  EXPECT_EQ(svg, to_svg(hostile_figure(), notes));
  const std::string metadata =
      "<metadata>\ncommand: draw &lt;/metadata&gt; &amp; more\nseed: 7\n</metadata>\n";
  ASSERT_EQ(occurrences(svg, metadata), 1U);
  std::string without = svg;
  without.erase(svg.find(metadata), metadata.size());
  EXPECT_EQ(without, to_svg(hostile_figure()));
  EXPECT_EQ(occurrences(without, "metadata"), 0U);
}

TEST(Notes, RefusesWhatIsNone) {
  // Goal: a note has a unique name and a value of one line. Method: use texts with one fault each.
  using Texts = std::vector<std::string>;
  EXPECT_EQ(notes_of(Texts{"a_b=c=d"}), (Notes{{.name = "a_b", .value = "c=d"}}));
  for (const Texts& bad : {Texts{""}, Texts{"a"}, Texts{"=b"}, Texts{"a="}, Texts{"A=b"},
                           Texts{"a b=c"}, Texts{"a=b\nc: d"}, Texts{"a=1", "a=2"}})
    EXPECT_THROW(notes_of(bad), base::Error) << bad.back();
}

TEST(Svg, StaysSmallForAMillionPoints) {
  // Goal: a long chain makes a small file that still shows its only spike. Method: draw a million
  // noisy points; check the file's size, and the spike's height among the coordinates.
  MadeUp made_up(2);
  Line line;
  for (int i = 0; i < 1'000'000; ++i)
    line.points.push_back({static_cast<double>(i), made_up.uniform()});
  line.points[500'123].y = 50;
  const std::string svg = to_svg({.panels = {Panel{.y_range = Range{0, 50}, .series = {line}}}});
  EXPECT_LT(svg.size(), 80'000U);
  // The spike reaches the frame's top, where the y axis begins.
  const auto axis = svg.find("<polyline points=\"", svg.find("</g>"));
  const auto comma = svg.find(',', axis);
  const std::string top = svg.substr(comma, svg.find(' ', comma) - comma + 1);
  EXPECT_NE(svg.substr(0, axis).find(top), std::string::npos) << top;
}

TEST(Svg, LeavesGapsAndMarksInfinities) {
  // Goal: NaN splits a line, a lone point becomes a dot, and minus infinity becomes a triangle.
  // Method: count elements of small figures; each has one axis line.
  EXPECT_EQ(occurrences(svg_of(Line{.points = {{0, 0}, {1, 1}, {2, k_nan}, {3, 1}, {4, 0}}}),
                        "<polyline"),
            3U);
  EXPECT_EQ(occurrences(svg_of(Line{.points = {{0, 0}}}), "<circle"), 1U);
  EXPECT_EQ(occurrences(svg_of(Line{.points = {{0, 0}, {1, -k_infinity}, {2, 0}}}), "<polygon"),
            1U);
  EXPECT_EQ(occurrences(svg_of(Line{.points = {{0, 0}, {1, 1}}}), "<polygon"), 0U);
}

TEST(Svg, DrawsEachKindOfSeries) {
  // Goal: every kind of series has its own element. Method: draw one labelled panel for each kind.
  EXPECT_EQ(occurrences(svg_of(Steps{.points = {{0, 0}, {1, 1}}}), "<polyline"), 2U);
  EXPECT_EQ(occurrences(svg_of(Markers{.points = {{0, 0}, {1, 1}}}), "h0"), 2U);
  EXPECT_EQ(occurrences(svg_of(HorizontalBand{.low = 1, .high = 2}), "fill-opacity"), 1U);
  EXPECT_EQ(occurrences(svg_of(HorizontalLine{.y = 1}), "stroke-dasharray"), 1U);
  EXPECT_EQ(occurrences(svg_of(VerticalLine{.x = 1}), "stroke-dasharray"), 1U);
  EXPECT_EQ(occurrences(svg_of(VerticalLine{.x = NAN}), "stroke-dasharray"), 0U);
  EXPECT_EQ(occurrences(svg_of(Arrow{.from = {0, 0}, .to = {1, 1}}), "<polygon"), 1U);
  EXPECT_EQ(occurrences(svg_of(Arrow{}), "<polygon"), 0U);
  EXPECT_EQ(occurrences(svg_of(Disc{}), "<ellipse"), 1U);
  EXPECT_EQ(occurrences(svg_of(Disc{.filled = false}), "<ellipse"), 1U);
  // Besides the series, the page and the frame's clip are `<rect>` elements.
  EXPECT_EQ(occurrences(svg_of(Rectangle{.high = {1, 1}}), "<rect"), 3U);
  EXPECT_EQ(occurrences(svg_of(Rectangle{.high = {1, 1}, .filled = false}), "fill=\"none\""),
            1U + occurrences(svg_of(Rectangle{.high = {1, 1}}), "fill=\"none\""));
  EXPECT_EQ(occurrences(svg_of(Rectangle{.high = {1, k_infinity}}), "<rect"), 2U);
  EXPECT_EQ(occurrences(svg_of(Polygon{.corners = {{0, 0}, {1, 0}, {0, 1}}}), "<polygon"), 1U);
  EXPECT_EQ(occurrences(svg_of(Polygon{.corners = {{0, 0}, {1, 0}, {0, k_infinity}}}), "<polygon"),
            0U);
  EXPECT_EQ(occurrences(svg_of(Text{.text = "words"}), ">words<"), 1U);
  EXPECT_EQ(occurrences(svg_of(Text{.text = "words"}), "paint-order"), 1U);
  EXPECT_EQ(occurrences(svg_of(Text{.text = "words", .inside = true}), "paint-order"), 0U);
  EXPECT_EQ(occurrences(svg_of(Line{.label = "legend"}), ">legend<"), 1U);
}

}  // namespace
}  // namespace sleight::plot
