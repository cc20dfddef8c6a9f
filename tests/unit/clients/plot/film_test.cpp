// Goal: a film's frame shows the still picture and the current moving series. Nothing of the
// previous frame remains. Raw frames and PNGs have the same pixels. Method: draw small figures as
// raw frames and as PNGs, and compare the pixels.
#include "clients/plot/film.h"

#include <cairo.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "clients/plot/png.h"
#include "common/base/error.h"

namespace sleight::plot {
namespace {

Figure with_disc_at(double x, Color color) {
  return {.width_px = 51,
          .height_px = 31,
          .panels = {{.x_range = Range{0, 10},
                      .y_range = Range{0, 10},
                      .axes = false,
                      .legend = false,
                      .series = {Disc{.center = {x, 5}, .radius_x = 2, .color = color}}}}};
}

/// Returns three bytes for each pixel (blue, green, red), row by row.
std::vector<std::byte> colors_of(base::BytesView pixels) {
  std::vector<std::byte> colors;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (i % 4 != 3) colors.push_back(pixels[i]);
  }
  return colors;
}

struct Image {
  int columns = 0;
  int rows = 0;
  std::vector<std::byte> colors{};
};

Image read_png(base::BytesView png) {
  const auto take = [](void* rest, unsigned char* to, unsigned int length) {
    auto& bytes = *static_cast<base::BytesView*>(rest);
    if (bytes.size() < length) return CAIRO_STATUS_READ_ERROR;
    std::ranges::copy(bytes.first(length), reinterpret_cast<std::byte*>(to));
    bytes = bytes.subspan(length);
    return CAIRO_STATUS_SUCCESS;
  };
  cairo_surface_t* surface = cairo_image_surface_create_from_png_stream(take, &png);
  EXPECT_EQ(cairo_surface_status(surface), CAIRO_STATUS_SUCCESS);
  Image image{.columns = cairo_image_surface_get_width(surface),
              .rows = cairo_image_surface_get_height(surface)};
  const auto* data = reinterpret_cast<const std::byte*>(cairo_image_surface_get_data(surface));
  const auto bytes = static_cast<std::size_t>(4 * image.columns * image.rows);
  if (data != nullptr) image.colors = colors_of({data, bytes});
  cairo_surface_destroy(surface);
  return image;
}

TEST(Film, AFrameIsTheStillPictureAndWhatMoves) {
  const Figure still = with_disc_at(2, palette::k_green);
  Figure both = with_disc_at(2, palette::k_green);
  both.panels[0].series.push_back(with_disc_at(6, palette::k_sky).panels[0].series[0]);
  Film film(still);
  const auto colors_of_film = [&] { return colors_of(film.pixels()); };
  const std::vector<std::byte> alone = colors_of_film();
  EXPECT_EQ(alone, colors_of(Film(still).pixels()));
  film.show(with_disc_at(6, palette::k_sky));
  const std::vector<std::byte> with_six = colors_of_film();
  EXPECT_EQ(with_six, colors_of(Film(both).pixels()));
  EXPECT_NE(with_six, alone);
  film.show(with_disc_at(8, palette::k_sky));
  EXPECT_NE(colors_of_film(), with_six);
  film.show(with_disc_at(6, palette::k_sky));
  EXPECT_EQ(colors_of_film(), with_six);
}

TEST(Film, SidesAreEvenAndBothFormsAreThoseOfAPicture) {
  const Figure figure = with_disc_at(2, palette::k_green);
  for (const double scale : {1.0, 0.5, 2.0}) {
    const Film film(figure, scale);
    EXPECT_EQ(film.columns(), scale == 1 ? 52U : scale == 2 ? 102U : 26U);
    EXPECT_EQ(film.rows(), scale == 1 ? 32U : scale == 2 ? 62U : 16U);
    const Image image = read_png(film.png());
    EXPECT_EQ(image.columns, static_cast<int>(film.columns()));
    EXPECT_EQ(image.rows, static_cast<int>(film.rows()));
    EXPECT_EQ(image.colors, colors_of(film.pixels()));
    // The frame equals the figure's picture. If the picture's width or height is odd, the frame has
    // one more white column or row.
    const Image picture = read_png(to_png(figure, scale));
    ASSERT_LE(picture.columns, image.columns);
    for (int row = 0; row < picture.rows; ++row) {
      const auto at = [row](const Image& of) {
        return of.colors.begin() + std::ptrdiff_t{3} * row * of.columns;
      };
      ASSERT_TRUE(
          std::equal(at(picture), at(picture) + std::ptrdiff_t{3} * picture.columns, at(image)))
          << scale << ", " << row;
    }
    EXPECT_EQ(image.colors.back(), std::byte{0xFF});
  }
}

TEST(Film, IsRefusedWhereItIsTooLarge) {
  EXPECT_THROW(Film(with_disc_at(2, palette::k_green), 1e6), base::Error);
}

}  // namespace
}  // namespace sleight::plot
