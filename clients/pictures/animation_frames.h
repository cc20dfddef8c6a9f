// Renders an animation's frames as PNG files or as one MP4, and its whole motion as one SVG
// picture.
//
// A frame shows the scene from above and from the front, or only one of these views. Two views are
// placed below or beside each other, whichever makes them larger. All frames of an animation show
// the same part of the scene at the same scale. Frame n (from 0) shows the bodies at time n / fps
// from the animation's beginning. The last frame is at the last multiple of 1 / fps up to the
// moment when all bodies rest.
//
// Still parts are drawn once for all frames (clients/plot/film.h). In one second, one core (2.4
// GHz, 2026-11-26, `sleight export --fps 200`) renders about 200 PNG files of one ball, 110 of a
// die, or 50 of HI. It renders 150, 70 or 50 film frames, including ffmpeg's work.
//
// Files appear complete or not at all: each is written under a temporary name and renamed. A folder
// of frames must be new or empty. An existing file is replaced, as with every `-o`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "clients/export/keys.h"
#include "clients/pictures/animation_figures.h"
#include "clients/plot/figure.h"
#include "common/motion/path.h"
#include "common/scene/scene.h"

namespace sleight::pictures {

enum class FrameViews : std::uint8_t {
  both,  ///< from above and from the front; only from the front if all bodies move in that plane
  above,
  front,
};

/// The look of a frame; lengths are in the figure's pixels.
struct FrameLook {
  FrameViews views = FrameViews::both;
  double width_max_px = 1280;
  double height_max_px = 720;
};

/// Draws the scene at a time, with the animation's title and the time as caption. The figure's
/// sides are even whole numbers. REQUIRES: a valid scene description, a motion of its bodies, sides
/// of at least 100.
plot::Figure frame_figure(const scene::Scene& scene, const ShownAnimation& animation, double t_s,
                          const FrameLook& look = {});

/// Maximum frames of an animation, over an hour at 24 per second, so that a damaged archive can't
/// fill disks.
inline constexpr std::size_t k_frames_max = 100'000;
inline constexpr double k_fps_max = gltf::k_fps_max;

/// Returns floor(duration * fps) + 1. Throws base::Error(usage) if the result exceeds k_frames_max,
/// or if fps is not above 0 and at most k_fps_max.
std::size_t frame_count(const motion::Animation& motion, double fps);

struct FramesOptions {
  double fps = 24;
  FrameLook look{};
  double scale = 1;            ///< image pixels per figure pixel; above 0
  std::string name = "frame";  ///< prefix of PNG files: NAME-0001.png
  /// Called after each frame. If `progress` throws, the work ends and leaves no files behind.
  std::function<void(std::size_t done, std::size_t of)> progress{};
};

/// Creates the folder with NAME-0001.png and so on, and returns the number of frames. Throws
/// base::Error: usage if the folder isn't empty, environment on a write error.
std::size_t write_png_frames(const scene::Scene& scene, const ShownAnimation& animation,
                             const std::string& folder, const FramesOptions& options);

/// Writes an H.264 film and returns the number of frames. The program `ffmpeg` receives the frames
/// as pixels. Throws base::Error(environment) with installation advice if ffmpeg is missing, or
/// with its last messages if it fails.
std::size_t write_mp4(const scene::Scene& scene, const ShownAnimation& animation,
                      const std::string& path, const FramesOptions& options);

/// Writes the picture of the whole motion (animation_figure). Throws base::Error(usage) unless the
/// path ends in .svg.
void write_motion_svg(const std::string& title, const scene::Scene& scene,
                      const ShownAnimation& animation, const std::string& path);

}  // namespace sleight::pictures
