#include "clients/plot/png.h"

#include <cairo.h>
#include <fmt/format.h>
#include <librsvg/rsvg.h>

#include <cmath>
#include <memory>
#include <string>

#include "clients/plot/svg.h"
#include "common/base/check.h"
#include "common/base/error.h"

#if defined(__SANITIZE_ADDRESS__)
// Pango loads fonts in a thread of its own, and it and fontconfig keep them until the process ends:
// not leaks, though the sanitizer can't see who holds them.
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libfontconfig\nleak:libpango\n";
}
#endif

namespace sleight::plot {

namespace {

template <auto release>
struct Release {
  template <class T>
  void operator()(T* resource) const {
    release(resource);
  }
};

using Handle = std::unique_ptr<RsvgHandle, Release<g_object_unref>>;
using Surface = std::unique_ptr<cairo_surface_t, Release<cairo_surface_destroy>>;
using Context = std::unique_ptr<cairo_t, Release<cairo_destroy>>;

[[noreturn]] void fail(GError* error) {
  std::string reason = error != nullptr ? error->message : "no reason given";
  g_clear_error(&error);
  throw base::Error(fmt::format("the picture can't be drawn: {}", reason));
}

void check(cairo_status_t status) {
  if (status == CAIRO_STATUS_SUCCESS) return;
  throw base::Error(fmt::format("the picture can't be drawn: {}", cairo_status_to_string(status)));
}

cairo_status_t append(void* bytes, const unsigned char* data, unsigned int length) {
  const auto* first = reinterpret_cast<const std::byte*>(data);
  auto& out = *static_cast<base::Bytes*>(bytes);
  out.insert(out.end(), first, first + length);
  return CAIRO_STATUS_SUCCESS;
}

}  // namespace

base::Bytes svg_to_png(std::string_view svg, double scale) {
  CHECK_GT(scale, 0.0);
  GError* error = nullptr;
  const Handle handle(
      rsvg_handle_new_from_data(reinterpret_cast<const guint8*>(svg.data()), svg.size(), &error));
  if (!handle) fail(error);
  double width = 0;
  double height = 0;
  if (rsvg_handle_get_intrinsic_size_in_pixels(handle.get(), &width, &height) == FALSE) {
    throw base::Error("the picture can't be drawn: its SVG gives no width and height in pixels");
  }
  const double columns = std::ceil(width * scale);
  const double rows = std::ceil(height * scale);
  if (!(columns >= 1 && rows >= 1 && columns <= k_png_side_max_px && rows <= k_png_side_max_px)) {
    throw base::Error(fmt::format(
        "a PNG of {} x {} pixels can't be drawn; its sides must be from 1 to {}: choose another "
        "size or scale",
        columns, rows, k_png_side_max_px));
  }
  const Surface surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(columns),
                                                   static_cast<int>(rows)));
  check(cairo_surface_status(surface.get()));
  const Context context(cairo_create(surface.get()));
  cairo_set_source_rgb(context.get(), 1, 1, 1);
  cairo_paint(context.get());
  const RsvgRectangle viewport{0, 0, columns, rows};
  if (rsvg_handle_render_document(handle.get(), context.get(), &viewport, &error) == FALSE) {
    fail(error);
  }
  check(cairo_status(context.get()));
  base::Bytes bytes;
  check(cairo_surface_write_to_png_stream(surface.get(), &append, &bytes));
  return bytes;
}

base::Bytes to_png(const Figure& figure, double scale) {
  return svg_to_png(to_svg(figure), scale);
}

}  // namespace sleight::plot
