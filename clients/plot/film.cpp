#include "clients/plot/film.h"

#include <cstddef>
#include <cstring>

#include "clients/plot/raster.h"
#include "clients/plot/svg.h"
#include "common/base/check.h"

namespace sleight::plot {
namespace {

int even(int side) {
  return side + side % 2;
}

/// Returns all rows' bytes. Rows with four bytes per pixel have no gaps between them.
std::size_t bytes_of(cairo_surface_t* surface) {
  return static_cast<std::size_t>(cairo_image_surface_get_stride(surface)) *
         static_cast<std::size_t>(cairo_image_surface_get_height(surface));
}

}  // namespace

struct Film::Surfaces {
  double scale;
  Surface still;
  Surface shown;
};

Film::Film(const Figure& still, double scale) {
  CHECK_GT(scale, 0.0);
  const PixelSize size = pixel_size(still.width_px, still.height_px, scale);
  const auto white = [&] { return white_surface(even(size.columns), even(size.rows)); };
  surfaces_ = std::make_unique<Surfaces>(scale, white(), white());
  SvgDocument(to_svg(still)).draw(surfaces_->still.get(), scale);
  cairo_surface_flush(surfaces_->still.get());
  CHECK_EQ(bytes_of(surfaces_->still.get()), std::size_t{4} * columns() * rows());
  show({.width_px = still.width_px, .height_px = still.height_px, .panels = {}});
}

Film::~Film() = default;

std::uint32_t Film::columns() const {
  return static_cast<std::uint32_t>(cairo_image_surface_get_width(surfaces_->still.get()));
}

std::uint32_t Film::rows() const {
  return static_cast<std::uint32_t>(cairo_image_surface_get_height(surfaces_->still.get()));
}

void Film::show(const Figure& moving) {
  cairo_surface_t* shown = surfaces_->shown.get();
  cairo_surface_flush(shown);
  std::memcpy(cairo_image_surface_get_data(shown),
              cairo_image_surface_get_data(surfaces_->still.get()), bytes_of(shown));
  cairo_surface_mark_dirty(shown);
  if (moving.panels.empty()) return;
  SvgDocument(svg_of_series(moving)).draw(shown, surfaces_->scale);
  cairo_surface_flush(shown);
}

base::Bytes Film::png() const {
  return quick_png_of(surfaces_->shown.get());
}

base::BytesView Film::pixels() const {
  const unsigned char* data = cairo_image_surface_get_data(surfaces_->shown.get());
  return {reinterpret_cast<const std::byte*>(data), bytes_of(surfaces_->shown.get())};
}

}  // namespace sleight::plot
