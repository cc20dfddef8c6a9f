// One animation as a film: its scene at moments a frame apart, as PNG files or as one MP4; and its
// whole motion in one picture, as SVG.
//
// A frame shows the scene from above and from the front, one beneath the other or beside it,
// whichever is larger; or one of both. Bodies are where their motion has them at the frame's time.
// All frames of an animation show the same part of the scene at the same scale. Counted from 0,
// frame n is of the time n / fps from the animation's beginning; the last one is of the last such
// time up to the moment when all bodies rest.
//
// What stands still is drawn once for all frames (clients/plot/film.h). A second of one core (2.4
// GHz, 2026-11-26, `sleight export --fps 200`) makes some 200 PNG files of one ball, 110 of a die
// and 50 of HI; of a film, ffmpeg's work included, 150, 70 and 50.
//
// Files are whole or not there: each is written beside its place and renamed. Nothing that is
// somebody else's is overwritten: a folder of frames must be new or empty; a file of the same name
// is replaced, as by every `-o`.
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
  both,  ///< from above and from the front; of what moves in a plane from the front alone
  above,
  front,
};

/// How a frame looks; lengths in the figure's pixels.
struct FrameLook {
  FrameViews views = FrameViews::both;
  double width_max_px = 1280;
  double height_max_px = 720;
};

/// The scene at a time, captioned with the animation's title and the time. Its sides are even whole
/// numbers. REQUIRES: a sound scene, a motion of its bodies, sides of at least 100.
plot::Figure frame_figure(const scene::Scene& scene, const ShownAnimation& animation, double t_s,
                          const FrameLook& look = {});

/// Most frames of an animation, over an hour at 24 a second: a damaged archive must not fill disks.
inline constexpr std::size_t k_frames_max = 100'000;
inline constexpr double k_fps_max = gltf::k_fps_max;

/// floor(duration * fps) + 1. Throws base::Error(usage) when that is more than k_frames_max, or fps
/// is not above 0 and at most k_fps_max.
std::size_t frame_count(const motion::Animation& motion, double fps);

struct FramesOptions {
  double fps = 24;
  FrameLook look{};
  double scale = 1;            ///< image pixels to one of the figure's; above 0
  std::string name = "frame";  ///< of PNG files: NAME-0001.png
  /// Called after each frame. What it throws ends the work and leaves nothing behind.
  std::function<void(std::size_t done, std::size_t of)> progress{};
};

/// Makes the folder and in it NAME-0001.png and so on; returns how many. Throws base::Error: usage
/// when something is in the folder already, environment when it can't be written.
std::size_t write_png_frames(const scene::Scene& scene, const ShownAnimation& animation,
                             const std::string& folder, const FramesOptions& options);

/// A film of H.264 by the program `ffmpeg`, which gets the frames as pixels; returns how many.
/// Throws base::Error(environment) with what to install where there is no ffmpeg, and with its last
/// words where it fails.
std::size_t write_mp4(const scene::Scene& scene, const ShownAnimation& animation,
                      const std::string& path, const FramesOptions& options);

/// The picture of the whole motion that animation_figure makes. Throws base::Error(usage) unless
/// the path ends in .svg.
void write_motion_svg(const std::string& title, const scene::Scene& scene,
                      const ShownAnimation& animation, const std::string& path);

}  // namespace sleight::pictures
