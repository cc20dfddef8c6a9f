// What a body looks like from afar: its outline and faces, seen along one direction.
//
// Thread safety: pure functions.
#pragma once

#include <vector>

#include "clients/plot/figure.h"
#include "worker/physics/scene/scene.h"

namespace sleight::scene_pictures {

/// Looks at a scene along parallel lines, from in front and above; z is up.
class Camera {
 public:
  /// Of the direction towards it: `azimuth` from x towards y, `elevation` above the horizon.
  Camera(double azimuth_rad, double elevation_rad);

  /// Metres to the right and up in the picture.
  plot::Point on_picture_m(const physics::Vec3& place_m) const;
  /// The greater the nearer.
  double nearness_m(const physics::Vec3& place_m) const;
  const physics::Vec3& towards() const { return towards_; }
  /// A world direction that is seen as such a one in the picture.
  physics::Vec3 seen_as(double right, double up) const { return right * right_ + up * up_; }

 private:
  physics::Vec3 towards_;
  physics::Vec3 right_;
  physics::Vec3 up_;
};

/// A patch of one brightness.
struct Patch {
  std::vector<plot::Point> outline_m;
  double brightness = 1;  ///< 0 to 1
};
/// A body is a disc, or patches in the order in which they are painted.
struct Look {
  bool is_disc = false;
  plot::Point centre_m;
  double radius_m = 0;
  std::vector<Patch> patches;
};

Look look_of(const physics::Shape& shape, const physics::Pose& pose, const Camera& camera);

/// The faces of a polyhedron that are turned to the camera.
std::vector<Patch> faces_of(const physics::ConvexView& view, const physics::Pose& pose,
                            const Camera& camera);

/// How bright a surface is.
double brightness_of(const physics::Vec3& normal);

}  // namespace sleight::scene_pictures
