#include "worker/physics/shape/round_piece.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace sleight::physics {
namespace {

/// Tolerance of equality: absolute for normals, and a share of the piece's size for lengths.
constexpr double k_alike = 1e-12;

using math::dot;
using math::norm;

bool is_finite(const Vec3& v) {
  return std::isfinite(v.x()) && std::isfinite(v.y()) && std::isfinite(v.z());
}

/// Returns the distance from a point to the furthest point of a feature.
double furthest_m(const RoundFeature& feature, const Vec3& axis, const Vec3& point_m) {
  const Vec3 from = feature.centre_m - point_m;
  const double along = dot(axis, from);
  const double across = length_across(axis, from) + feature.circle_m;
  return std::sqrt(along * along + across * across) + feature.radius_m;
}

}  // namespace

base::Result<RoundPiece, ShapeError> RoundPiece::make(const RoundDescription& description) {
  using Kind = ShapeError::Kind;
  const std::size_t count = description.rings.size() + description.balls.size();
  if (count == 0) return ShapeError{.kind = Kind::no_parts};
  if (count > k_round_features_max)
    return ShapeError{.kind = Kind::too_many_features, .index = count};
  if (!is_finite(description.origin_m) || !(std::fabs(norm(description.axis) - 1) < 1e-12))
    return ShapeError{.kind = Kind::no_axis};
  RoundPiece piece;
  piece.axis_ = math::normalized(description.axis);
  piece.origin_m_ = description.origin_m;
  for (const RoundRing& ring : description.rings) {
    piece.features_.push_back({.centre_m = description.origin_m + ring.height_m * piece.axis_,
                               .height_m = ring.height_m,
                               .circle_m = ring.circle_m,
                               .radius_m = ring.radius_m});
  }
  for (const RoundBall& ball : description.balls)
    piece.features_.push_back({.centre_m = ball.centre_m,
                               .height_m = dot(piece.axis_, ball.centre_m - description.origin_m),
                               .radius_m = ball.radius_m});
  Vec3 sum = Vec3::Zero();
  piece.margin_m_ = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < count; ++i) {
    const RoundFeature& feature = piece.features_[i];
    if (!is_finite(feature.centre_m) || !std::isfinite(feature.circle_m))
      return ShapeError{.kind = Kind::not_finite, .index = i};
    if (!(feature.radius_m > 0 && feature.circle_m >= 0 && std::isfinite(feature.radius_m)))
      return ShapeError{
          .kind = Kind::dimension_not_positive, .index = i, .measured = feature.radius_m};
    piece.margin_m_ = std::min(piece.margin_m_, feature.radius_m);
    piece.r_outer_m_ = std::max(piece.r_outer_m_, furthest_m(feature, piece.axis_, Vec3::Zero()));
    sum += feature.centre_m;
  }
  piece.centre_m_ = sum / static_cast<double>(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double share = piece.features_[i].radius_m / piece.r_outer_m_;
    if (share < k_round_edge_min)
      return ShapeError{.kind = Kind::sharp, .index = i, .measured = share};
  }
  piece.drop_held();
  piece.find_profile();
  return piece;
}

double RoundPiece::reach_m(const Vec3& direction) const {
  const double across = length_across(axis_, direction);
  double most_m = -std::numeric_limits<double>::infinity();
  for_each_reach(direction, across,
                 [&](const RoundFeature&, double reach_m) { most_m = std::max(most_m, reach_m); });
  return most_m;
}

ConvexView RoundPiece::view() const {
  ConvexView view;
  view.round = this;
  view.r_outer_m = r_outer_m_;
  view.centre_m = centre_m_;
  return view;
}

// ---- the profile --------------------------------------------------------------------------------

/// Returns a feature's arc. An arc ends at the first tangent that it shares with another feature.
/// After this tangent, the other feature reaches further. `next` is the other feature; if the arc
/// is the last, `next` is `feature`.
ProfileArc RoundPiece::arc_from(std::uint32_t feature, const ProfileNormal& from,
                                std::uint32_t& next) const {
  ProfileArc arc{.feature = feature, .from = from, .to = {0, -1}};
  const RoundFeature& own = features_[feature];
  next = feature;
  double way_m = 0;
  // Along the profile, normals turn from (0, 1) down to (0, -1). So a later normal has a smaller
  // axial component.
  for (std::uint32_t i = 0; i < features_.size(); ++i) {
    if (i == feature) continue;
    // The discs share a tangent line with normal e if e.D = own.r - other.r.
    const double across_m = features_[i].circle_m - own.circle_m;
    const double along_m = features_[i].height_m - own.height_m;
    const double square = across_m * across_m + along_m * along_m;
    const double less_m = own.radius_m - features_[i].radius_m;
    if (!(square > less_m * less_m)) continue;  // one disc contains the other
    const double root = std::sqrt(square - less_m * less_m);
    ProfileNormal normal{(less_m * across_m - root * along_m) / square,
                         (less_m * along_m + root * across_m) / square};
    if (normal.across < 0 && normal.across > -k_alike) normal.across = 0;
    if (normal.across < 0 || normal.along > from.along + k_alike) continue;
    const bool first = normal.along > arc.to.along + k_alike;
    const bool further = normal.along > arc.to.along - k_alike && square > way_m * way_m;
    if (!first && !(next != feature && further)) continue;
    arc.to = normal;
    next = i;
    way_m = std::sqrt(square);
  }
  return arc;
}

/// If a feature contains another one, removes the other. Of equal features, keeps one.
void RoundPiece::drop_held() {
  const auto holds = [&](const RoundFeature& big, const RoundFeature& small) {
    const bool on_axis = big.circle_m > 0 || small.circle_m > 0;
    const double out_m = big.circle_m - small.circle_m;
    const double up_m = big.height_m - small.height_m;
    const double apart_m = on_axis ? std::sqrt(out_m * out_m + up_m * up_m) +
                                         length_across(axis_, big.centre_m - small.centre_m)
                                   : norm(big.centre_m - small.centre_m);
    return apart_m <= big.radius_m - small.radius_m + k_alike * r_outer_m_;
  };
  std::vector<RoundFeature> kept;
  for (std::size_t i = 0; i < features_.size(); ++i) {
    bool is_held = false;
    for (std::size_t j = 0; j < features_.size() && !is_held; ++j) {
      if (i == j || !holds(features_[j], features_[i])) continue;
      is_held = j < i || !holds(features_[i], features_[j]);
    }
    if (!is_held) kept.push_back(features_[i]);
  }
  features_ = std::move(kept);
}

void RoundPiece::find_profile() {
  const auto off_axis = [&](const RoundFeature& one) {
    return length_across(axis_, one.centre_m - origin_m_) > k_alike * r_outer_m_;
  };
  if (std::ranges::any_of(features_, off_axis)) return;
  for (RoundFeature& feature : features_)
    feature.centre_m = origin_m_ + feature.height_m * axis_;
  // Start at the highest feature. If several are equally high, start at the widest of them.
  std::uint32_t now = 0;
  for (std::uint32_t i = 1; i < features_.size(); ++i) {
    const double top_m = features_[i].height_m + features_[i].radius_m;
    const double best_m = features_[now].height_m + features_[now].radius_m;
    const bool same = std::fabs(top_m - best_m) <= k_alike * r_outer_m_;
    if (same ? features_[i].circle_m > features_[now].circle_m : top_m > best_m) now = i;
  }
  ProfileNormal from{0, 1};
  if (features_[now].circle_m > 0) flats_.push_back(from);
  for (std::size_t n = 0; n < 2 * features_.size(); ++n) {
    std::uint32_t next = now;
    arcs_.push_back(arc_from(now, from, next));
    from = arcs_.back().to;
    if (next == now) break;
    flats_.push_back(from);
    now = next;
  }
  if (features_[arcs_.back().feature].circle_m > 0) flats_.push_back({0, -1});
}

double RoundPiece::radius_at_m(double height_m) const {
  // The profile is convex. So the radius is the least one that the lines and arcs allow at that
  // height.
  double widest_m = 0;
  const auto point_of = [&](const RoundFeature& one, const ProfileNormal& normal) {
    return ProfileNormal{one.circle_m + one.radius_m * normal.across,
                         one.height_m + one.radius_m * normal.along};
  };
  for (std::size_t i = 0; i < arcs_.size(); ++i) {
    const RoundFeature& one = features_[arcs_[i].feature];
    const ProfileNormal top = point_of(one, arcs_[i].from);
    const ProfileNormal bottom = point_of(one, arcs_[i].to);
    if (height_m <= top.along && height_m >= bottom.along) {
      const double above_m = height_m - one.height_m;
      widest_m = std::max(
          widest_m,
          one.circle_m + std::sqrt(std::max(0.0, one.radius_m * one.radius_m - above_m * above_m)));
    }
    if (i + 1 == arcs_.size()) break;
    const ProfileNormal end = point_of(features_[arcs_[i + 1].feature], arcs_[i + 1].from);
    if (height_m < bottom.along && height_m > end.along) {
      const double share = (bottom.along - height_m) / (bottom.along - end.along);
      widest_m = std::max(widest_m, bottom.across + share * (end.across - bottom.across));
    }
  }
  return widest_m;
}

}  // namespace sleight::physics
