#include "clients/plot/svg.h"

#include <glib.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/base/error.h"
#include "tests/support/numbers.h"
#include "tests/unit/clients/plot/examples.h"

namespace sleight::plot {
namespace {

// Returns GLib's error message about an XML text, or an empty string if the text is well-formed.
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
  // Goal: the SVG of any figure is well-formed XML without NaN or infinity. Method: let GLib parse
  // the SVG of the example figures, of an empty figure and of an empty panel. GLib must refuse
  // broken XML.
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
  // Goal: the SVG escapes markup in titles, labels and other texts of a figure.
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
  // Goal: the metadata of an SVG contains each note on its own line. Special characters are
  // escaped. Notes change nothing else in the SVG. Method: remove the metadata from an SVG with
  // notes, and compare the rest with an SVG without notes.
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
  // Goal: a note is refused unless its name is valid and unique and its value is one line.
  using Texts = std::vector<std::string>;
  EXPECT_EQ(notes_of(Texts{"a_b=c=d"}), (Notes{{.name = "a_b", .value = "c=d"}}));
  for (const Texts& bad : {Texts{""}, Texts{"a"}, Texts{"=b"}, Texts{"a="}, Texts{"A=b"},
                           Texts{"a b=c"}, Texts{"a=b\nc: d"}, Texts{"a=1", "a=2"}})
    EXPECT_THROW(notes_of(bad), base::Error) << bad.back();
}

TEST(Svg, StaysSmallForAMillionPoints) {
  // Goal: the SVG of a million points is a small file that still shows the only spike. Method: draw
  // a million random points with one spike. Check the file's size, and find the spike's height
  // among the coordinates.
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
  // Goal: a NaN splits a line, a lone point is drawn as a dot, and a point at minus infinity is
  // drawn as a triangle. Method: count the elements in the SVG of small figures. Each SVG also has
  // one polyline for the axes.
  EXPECT_EQ(occurrences(svg_of(Line{.points = {{0, 0}, {1, 1}, {2, k_nan}, {3, 1}, {4, 0}}}),
                        "<polyline"),
            3U);
  EXPECT_EQ(occurrences(svg_of(Line{.points = {{0, 0}}}), "<circle"), 1U);
  EXPECT_EQ(occurrences(svg_of(Line{.points = {{0, 0}, {1, -k_infinity}, {2, 0}}}), "<polygon"),
            1U);
  EXPECT_EQ(occurrences(svg_of(Line{.points = {{0, 0}, {1, 1}}}), "<polygon"), 0U);
}

TEST(Svg, DrawsEachKindOfSeries) {
  // Goal: each kind of series is drawn with its own SVG element.
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
  // The page and the frame's clip path add two `<rect>` elements.
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
