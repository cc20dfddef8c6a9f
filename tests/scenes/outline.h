// The appearance of a body from afar: its outline and faces, seen along one direction.
//
// Thread safety: pure functions.
#pragma once

#include <vector>

#include "clients/plot/figure.h"
#include "worker/physics/scene/scene.h"

namespace sleight::scene_pictures {

/// A parallel projection from in front and above. The z axis points up.
class Camera {
 public:
  /// Direction towards the camera: `azimuth` from x towards y, `elevation` above the horizon.
  Camera(double azimuth_rad, double elevation_rad);

  /// Returns a place's position in the picture: metres to the right, and metres up.
  plot::Point on_picture_m(const physics::Vec3& place_m) const;
  /// Returns the place's coordinate in the direction of the camera. Nearer places have greater
  /// values.
  double nearness_m(const physics::Vec3& place_m) const;
  const physics::Vec3& towards() const { return towards_; }
  /// Returns the world's direction for a direction (right, up) in the picture.
  physics::Vec3 seen_as(double right, double up) const { return right * right_ + up * up_; }

 private:
  physics::Vec3 towards_;
  physics::Vec3 right_;
  physics::Vec3 up_;
};

struct Patch {
  std::vector<plot::Point> outline_m;
  double brightness = 1;  ///< 0 to 1
};
/// A body's appearance: a disc, or patches in painting order.
struct Look {
  bool is_disc = false;
  plot::Point centre_m;
  double radius_m = 0;
  std::vector<Patch> patches;
};

Look look_of(const physics::Shape& shape, const physics::Pose& pose, const Camera& camera);

/// Returns the faces of a polyhedron that are turned to the camera.
std::vector<Patch> faces_of(const physics::ConvexView& view, const physics::Pose& pose,
                            const Camera& camera);

double brightness_of(const physics::Vec3& normal);

}  // namespace sleight::scene_pictures
