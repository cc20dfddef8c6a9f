#include "tests/scenes/strip.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "clients/plot/svg_writer.h"
#include "common/math/vector.h"
#include "tests/scenes/outline.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::scene_pictures {
namespace {

using physics::Vec3;

constexpr double k_picture_px = 210;
constexpr double k_height_px = 190;
constexpr double k_label_px = 22;
constexpr double k_margin_px = 8;
/// On each side, this share of places may be outside the frame, because some bodies fly away.
constexpr double k_left_out = 0.25;
constexpr double k_azimuth_rad = -1.2;
constexpr double k_elevation_rad = 0.35;

struct DrawnBody {
  std::size_t body;
  Look look;
  double nearness_m;
};
struct Moment {
  double time_s = 0;
  std::vector<DrawnBody> bodies;
};

/// The visible part of the scene, in metres.
struct Frame {
  double left = std::numeric_limits<double>::infinity();
  double right = -std::numeric_limits<double>::infinity();
  double bottom = std::numeric_limits<double>::infinity();
  double top = -std::numeric_limits<double>::infinity();
  void include(const plot::Point& at, double radius_m) {
    left = std::min(left, at.x - radius_m);
    right = std::max(right, at.x + radius_m);
    bottom = std::min(bottom, at.y - radius_m);
    top = std::max(top, at.y + radius_m);
  }
};

/// Returns a frame that shows all bodies at the first moment, and most bodies at later moments.
Frame frame_of(const std::vector<Moment>& moments) {
  Frame frame;
  std::vector<double> across;
  std::vector<double> up;
  double radius_m = 0;
  for (const Moment& moment : moments) {
    for (const DrawnBody& body : moment.bodies) {
      across.push_back(body.look.centre_m.x);
      up.push_back(body.look.centre_m.y);
      radius_m = std::max(radius_m, body.look.radius_m);
      if (&moment == &moments.front()) frame.include(body.look.centre_m, body.look.radius_m);
    }
  }
  std::ranges::sort(across);
  std::ranges::sort(up);
  const auto skip = static_cast<std::size_t>(k_left_out * static_cast<double>(across.size()));
  for (std::size_t i = skip; i + skip < across.size(); ++i)
    frame.include({across[i], up[i]}, radius_m);
  if (frame.left > frame.right) frame.include({0, 0}, 1);
  return frame;
}

plot::Color shaded(const plot::Color& color, double brightness) {
  const auto part = [&](std::uint8_t channel) {
    return static_cast<std::uint8_t>(std::clamp(brightness * channel, 0.0, 255.0));
  };
  return {part(color.red), part(color.green), part(color.blue), color.opacity};
}

/// Returns patches of static geometry. A nearly level plane becomes a square.
std::vector<Patch> statics_of(const physics::Scene& scene, const Camera& camera,
                              const Vec3& middle_m, double extent_m) {
  std::vector<Patch> patches;
  for (const physics::StaticPlane& plane : scene.planes) {
    const Vec3& n = plane.outside.normal;
    if (n.z() < 0.7) continue;
    const Vec3 foot = middle_m - (math::dot(n, middle_m) - plane.outside.offset_m) * n;
    const Vec3 first = math::normalized(math::cross(n, Vec3(0, 1, 0)));
    const Vec3 second = math::cross(n, first);
    Patch patch{.outline_m = {}, .brightness = brightness_of(n)};
    for (const auto& [a, b] : {std::pair{1, 1}, {1, -1}, {-1, -1}, {-1, 1}})
      patch.outline_m.push_back(camera.on_picture_m(foot + extent_m * (a * first + b * second)));
    patches.push_back(std::move(patch));
  }
  for (const physics::StaticConvex& convex : scene.convexes)
    std::ranges::move(faces_of(convex.polyhedron->view(), {}, camera), std::back_inserter(patches));
  for (const physics::StaticMesh& mesh : scene.meshes) {
    const auto vertices = mesh.mesh->vertices_m();
    for (const auto& triangle : mesh.mesh->triangles()) {
      const Vec3& a = vertices[triangle[0]];
      const Vec3& b = vertices[triangle[1]];
      const Vec3& c = vertices[triangle[2]];
      const Vec3 normal = math::cross(Vec3(b - a), Vec3(c - a));
      if (!(math::norm(normal) > 0)) continue;
      Patch patch{.outline_m = {}, .brightness = brightness_of(math::normalized(normal))};
      for (const Vec3& corner : {a, b, c})
        patch.outline_m.push_back(camera.on_picture_m(corner));
      patches.push_back(std::move(patch));
    }
  }
  return patches;
}

class Painter {
 public:
  Painter(plot::SvgWriter& svg, const Frame& frame) : svg_(svg), frame_(frame) {
    const double width_m = std::max(frame.right - frame.left, 1e-9);
    const double height_m = std::max(frame.top - frame.bottom, 1e-9);
    px_per_m_ = std::min((k_picture_px - 2 * k_margin_px) / width_m,
                         (k_height_px - 2 * k_margin_px) / height_m);
  }

  void picture(const Moment& moment, std::size_t nth, const std::vector<Patch>& statics) {
    left_px_ = static_cast<double>(nth) * k_picture_px;
    svg_.begin_clipped({left_px_, 0, k_picture_px - 2, k_height_px});
    svg_.rectangle({left_px_, 0, k_picture_px - 2, k_height_px}, {0xF7, 0xF7, 0xF7});
    for (const Patch& patch : statics)
      polygon(patch, {0xC9, 0xCF, 0xD6, 0.45});
    for (const DrawnBody& body : moment.bodies)
      draw(body);
    svg_.end_group();
    svg_.text({left_px_ + 0.5 * k_picture_px, k_height_px + 15},
              fmt::format("{:.3g} s", moment.time_s), {.size = 11, .anchor = plot::Anchor::middle});
  }

 private:
  plot::Point px(const plot::Point& at_m) const {
    const double middle_x = 0.5 * (frame_.left + frame_.right);
    const double middle_y = 0.5 * (frame_.bottom + frame_.top);
    return {left_px_ + 0.5 * k_picture_px + px_per_m_ * (at_m.x - middle_x),
            0.5 * k_height_px - px_per_m_ * (at_m.y - middle_y)};
  }
  void polygon(const Patch& patch, const plot::Color& color) {
    std::vector<plot::Point> points;
    for (const plot::Point& at_m : patch.outline_m)
      points.push_back(px(at_m));
    svg_.polygon(points, shaded(color, patch.brightness));
  }
  void draw(const DrawnBody& body) {
    const plot::Color color = plot::palette::series(body.body);
    if (!body.look.is_disc) {
      for (const Patch& patch : body.look.patches)
        polygon(patch, color);
      return;
    }
    const plot::Point centre = px(body.look.centre_m);
    const double radius_px = px_per_m_ * body.look.radius_m;
    svg_.disc(centre, radius_px, shaded(color, 0.8));
    svg_.disc({centre.x - 0.25 * radius_px, centre.y - 0.3 * radius_px}, 0.45 * radius_px,
              color.with_opacity(0.9));
  }

  plot::SvgWriter& svg_;
  const Frame& frame_;
  double px_per_m_ = 1;
  double left_px_ = 0;
};

}  // namespace

Strip strip_of(const physics::scenes::Setting& setting, const std::string& title) {
  const Camera camera(k_azimuth_rad, k_elevation_rad);
  Strip strip;
  std::vector<Moment> moments;
  auto started = physics::Simulation::start(setting.scene, {.record = false});
  if (!started) {
    strip.error = started.error().message;
    strip.refused = !physics::is_failure(started.error().kind);
    return strip;
  }
  physics::Simulation simulation = std::move(started).value();
  Vec3 middle_m = Vec3::Zero();
  std::size_t seen = 0;
  for (std::size_t i = 0; i < k_moments; ++i) {
    const double time_s =
        setting.duration_s * static_cast<double>(i) / static_cast<double>(k_moments - 1);
    const auto error = simulation.run_until(physics::Tick{} + physics::ticks_after(time_s));
    if (error) {
      strip.error = error->message;
      break;
    }
    moments.push_back({.time_s = time_s, .bodies = {}});
    for (std::uint32_t body = 0; body < setting.scene.bodies.size(); ++body) {
      if (!simulation.started({body})) continue;
      const physics::Pose pose = simulation.pose({body}, simulation.now());
      middle_m += pose.position_m;
      ++seen;
      moments.back().bodies.push_back({body,
                                       look_of(setting.scene.bodies[body].shape, pose, camera),
                                       camera.nearness_m(pose.position_m)});
    }
    std::ranges::stable_sort(moments.back().bodies, {}, &DrawnBody::nearness_m);
  }
  if (seen > 0) middle_m /= static_cast<double>(seen);
  const Frame frame = frame_of(moments);
  plot::SvgWriter svg(k_moments * k_picture_px, k_height_px + k_label_px, title);
  Painter painter(svg, frame);
  const std::vector<Patch> statics =
      statics_of(setting.scene, camera, middle_m,
                 std::max(frame.right - frame.left, frame.top - frame.bottom));
  for (std::size_t i = 0; i < moments.size(); ++i)
    painter.picture(moments[i], i, statics);
  strip.svg = svg.finish();
  return strip;
}

}  // namespace sleight::scene_pictures
