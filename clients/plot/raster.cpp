#include "clients/plot/raster.h"

#include <fmt/format.h>
#include <libpng16/png.h>
#include <librsvg/rsvg.h>

#include <cmath>
#include <csetjmp>
#include <cstddef>
#include <string>
#include <thread>

#include "clients/plot/png.h"
#include "common/base/error.h"
#include "common/base/memory.h"

#if defined(__SANITIZE_ADDRESS__)
// Pango loads fonts in its own thread, and Pango and fontconfig hold them until the process ends.
// Such memory isn't a leak, but the sanitizer can't see its owners.
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libfontconfig\nleak:libpango\n";
}
#endif

namespace sleight::plot {
namespace {

struct ReleaseContext {
  void operator()(cairo_t* context) const { cairo_destroy(context); }
};
using Context = std::unique_ptr<cairo_t, ReleaseContext>;

[[noreturn]] void fail(GError* error) {
  std::string reason = error != nullptr ? error->message : "no reason given";
  g_clear_error(&error);
  throw base::Error(fmt::format("can't draw the picture: {}", reason));
}

constexpr std::size_t k_drawing_bytes = std::size_t{128} << 20U;

/// quick_png_of compresses rows without filters, which suits flat colours.
constexpr int k_quick_level = 2;

void append_png(png_structp writer, png_bytep data, std::size_t length) {
  const auto* first = reinterpret_cast<const std::byte*>(data);
  auto& out = *static_cast<base::Bytes*>(png_get_io_ptr(writer));
  out.insert(out.end(), first, first + length);
}

/// Returns false on failure. No local may have a destructor here, because libpng leaves by longjmp.
bool write_quickly(png_structp writer, png_infop info, cairo_surface_t* surface,
                   base::Bytes& bytes) {
  if (setjmp(png_jmpbuf(writer)) != 0) return false;
  png_set_write_fn(writer, &bytes, &append_png, nullptr);
  const int rows = cairo_image_surface_get_height(surface);
  png_set_IHDR(writer, info, static_cast<png_uint_32>(cairo_image_surface_get_width(surface)),
               static_cast<png_uint_32>(rows), 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_compression_level(writer, k_quick_level);
  png_set_filter(writer, PNG_FILTER_TYPE_BASE, PNG_FILTER_NONE);
  png_write_info(writer, info);
  // Cairo's pixels: blue, green, red and an unused byte.
  png_set_bgr(writer);
  png_set_filler(writer, 0, PNG_FILLER_AFTER);
  const unsigned char* data = cairo_image_surface_get_data(surface);
  for (int row = 0; row < rows; ++row)
    png_write_row(writer, data + std::ptrdiff_t{row} * cairo_image_surface_get_stride(surface));
  png_write_end(writer, info);
  return true;
}

cairo_status_t append(void* bytes, const unsigned char* data, unsigned int length) {
  const auto* first = reinterpret_cast<const std::byte*>(data);
  auto& out = *static_cast<base::Bytes*>(bytes);
  out.insert(out.end(), first, first + length);
  return CAIRO_STATUS_SUCCESS;
}

}  // namespace

void check_cairo(cairo_status_t status) {
  if (status == CAIRO_STATUS_SUCCESS) return;
  throw base::Error(fmt::format("can't draw the picture: {}", cairo_status_to_string(status)));
}

Surface white_surface(int columns, int rows) {
  Surface surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24, columns, rows));
  check_cairo(cairo_surface_status(surface.get()));
  const Context context(cairo_create(surface.get()));
  cairo_set_source_rgb(context.get(), 1, 1, 1);
  cairo_paint(context.get());
  check_cairo(cairo_status(context.get()));
  return surface;
}

SvgDocument::SvgDocument(std::string_view svg) {
  // Require memory for fonts too: librsvg, pango and fontconfig crash without enough memory.
  base::require_memory(k_drawing_bytes);
  // Pango starts a thread and ends the process if that fails, so try to start a thread first.
  std::thread([] {}).join();
  GError* error = nullptr;
  RsvgHandle* handle =
      rsvg_handle_new_from_data(reinterpret_cast<const guint8*>(svg.data()), svg.size(), &error);
  if (handle == nullptr) fail(error);
  handle_ = handle;
  if (rsvg_handle_get_intrinsic_size_in_pixels(handle, &width_px_, &height_px_) == FALSE) {
    g_object_unref(handle_);
    throw base::Error("can't draw the picture: its SVG has no width and height in pixels");
  }
}

SvgDocument::~SvgDocument() {
  g_object_unref(handle_);
}

void SvgDocument::draw(cairo_surface_t* surface, double scale) const {
  const Context context(cairo_create(surface));
  const RsvgRectangle viewport{0, 0, std::ceil(scale * width_px_), std::ceil(scale * height_px_)};
  GError* error = nullptr;
  if (rsvg_handle_render_document(static_cast<RsvgHandle*>(handle_), context.get(), &viewport,
                                  &error) == FALSE) {
    fail(error);
  }
  check_cairo(cairo_status(context.get()));
}

PixelSize pixel_size(double width_px, double height_px, double scale) {
  const double columns = std::ceil(width_px * scale);
  const double rows = std::ceil(height_px * scale);
  if (!(columns >= 1 && rows >= 1 && columns <= k_png_side_max_px && rows <= k_png_side_max_px)) {
    throw base::Error(
        fmt::format("can't draw a PNG of {} x {} pixels: width and height must be from 1 to {} "
                    "pixels; choose another size or scale",
                    columns, rows, k_png_side_max_px));
  }
  return {.columns = static_cast<int>(columns), .rows = static_cast<int>(rows)};
}

base::Bytes png_of(cairo_surface_t* surface) {
  base::Bytes bytes;
  check_cairo(cairo_surface_write_to_png_stream(surface, &append, &bytes));
  return bytes;
}

base::Bytes quick_png_of(cairo_surface_t* surface) {
  cairo_surface_flush(surface);
  base::Bytes bytes;
  png_structp writer = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = writer != nullptr ? png_create_info_struct(writer) : nullptr;
  const bool written = info != nullptr && write_quickly(writer, info, surface, bytes);
  png_destroy_write_struct(&writer, &info);
  if (!written) throw base::Error("can't draw the picture: writing the PNG failed");
  return bytes;
}

}  // namespace sleight::plot
