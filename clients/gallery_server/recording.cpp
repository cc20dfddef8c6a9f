#include "clients/gallery_server/recording.h"

#include <vector>

#include "clients/gallery_server/meshes.h"
#include "common/motion/fields.h"

namespace sleight::gallery {

void add_segments(Packed& to, const std::string& prefix,
                  std::span<const motion::Segment> segments) {
  motion::for_each_field(motion::k_fields,
                         [&]<class Value>(const motion::Field<motion::Segment, Value>& field) {
                           std::vector<motion::Element<Value>> column;
                           column.reserve(segments.size() * motion::k_width<Value>);
                           for (const motion::Segment& segment : segments) {
                             const auto elements = motion::elements_of(segment.*field.member);
                             column.insert(column.end(), elements.begin(), elements.end());
                           }
                           to.add(prefix + field.name, column);
                         });
}

json::Value add_animation(Packed& to, const std::string& prefix, const std::string& name,
                          const browse::KeptAnimation& animation, const scene::Scene& scene) {
  std::vector<motion::Segment> segments;
  for (const motion::Path& path : animation.motion.paths())
    segments.insert(segments.end(), path.segments().begin(), path.segments().end());
  add_segments(to, prefix, segments);
  json::Value meshes = add_meshes(to, prefix, scene, own_features(scene, animation.own),
                                  animation.own, animation.offsets_m);
  return {{"name", name},
          {"end_s", animation.motion.end_s()},
          {"columns", prefix},
          {"meshes", std::move(meshes)}};
}

}  // namespace sleight::gallery
