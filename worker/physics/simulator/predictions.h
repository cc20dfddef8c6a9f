// When bodies meet one another, and static geometry.
//
// Invariants
//   1. Every prediction is a function of the segments of the bodies involved, and of the contacts
//      that a pair has just had: it does not depend on the caller or on the time of the call.
//   2. What a search found is the contact of the event that it led to, bit for bit as it would be
//      computed there.
// Knows nothing of queues and bounding volumes. Thread safety: none.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "worker/physics/collision/near_places.h"
#include "worker/physics/collision/piece_searches.h"
#include "worker/physics/contact/recent_contacts.h"
#include "worker/physics/simulator/bodies.h"
#include "worker/physics/simulator/lanes.h"
#include "worker/physics/simulator/met_statics.h"
#include "worker/physics/simulator/pair_graph.h"

namespace sleight::physics {

class Predictions {
 public:
  /// Borrows both. `contacts_matter`: pairs that have just met collide only at smaller gaps.
  Predictions(Bodies& bodies, const MetStatics& statics, bool contacts_matter);
  Predictions(const Predictions&) = delete;
  Predictions& operator=(const Predictions&) = delete;

  // Two bodies. `search` keeps what a search of convex pieces has done so far; it is taken when
  // first needed and released by end_search.
  /// When the pair collides next, as its two segments say. REQUIRES: a < b; nothing happens to the
  /// pair between the later begin of their segments and `now`.
  Prediction predict(BodyId a, BodyId b, Tick now, std::uint32_t& search);
  /// Goes on with a prediction that was not certain. REQUIRES: its tick is `now`.
  Prediction look(BodyId a, BodyId b, Tick now, std::uint32_t search);
  void end_search(std::uint32_t& search) { searches_.release(search); }
  /// As predict, for the periodic image that collides first: for the algorithm without boxes.
  /// REQUIRES: the world is periodic.
  Prediction predict_any_image(BodyId a, BodyId b, Tick now) const;
  /// Whether the two touch or overlap at a tick.
  bool touching(BodyId a, BodyId b, Tick tick);

  // Spheres in flight (flight_predictions.cpp).
  /// Whether both are spheres in flight, in a scene without slow contacts: a closed form.
  bool free_spheres(BodyId a, BodyId b) const {
    return bodies_.flight(a).radius_m > 0 && bodies_.flight(b).radius_m > 0 && !recent_.enabled();
  }
  /// Whether predict_flight is for this body.
  bool in_free_flight(BodyId body) const {
    return bodies_.flight(body).radius_m > 0 && !recent_.enabled();
  }
  /// The closed form. In a periodic world it is for the image that is nearest at `now`.
  /// REQUIRES: free_spheres(a, b); a < b.
  Prediction predict_free_spheres(BodyId a, BodyId b, Tick now) const;
  /// The same for the image of b at a shift.
  Prediction predict_free_spheres_at(BodyId a, BodyId b, const Vec3& shift_m) const;
  /// predict_free_spheres for some edges of a body; `changes` are of all bodies. False if some of
  /// the others are not in free flight: those edges are predicted as not colliding, and the caller
  /// must do them again. REQUIRES: in_free_flight(body).
  bool predict_flight(BodyId body, const PairEdges& edges, std::span<const std::uint32_t> changes,
                      Tick now) const;

  // A body and static geometry.
  Prediction predict_static(BodyId body, StaticId met, Tick now, std::uint32_t& search, Tick until);
  Prediction look_static(BodyId body, StaticId met, Tick now, std::uint32_t search, Tick until);

  // At the event that a prediction led to.
  PieceContact contact_at(BodyId a, BodyId b, const EventKey& event);
  PieceContact static_contact_at(BodyId body, StaticId met, const EventKey& event);

  // What happened to bodies.
  /// A body is elsewhere, or moves otherwise.
  void moved() {
    found_.tick = Tick{-1};
    hull_look_.tick = Tick{-1};
  }
  /// It has begun a segment.
  void began(BodyId body) {
    if (places_.enabled()) note_place(body);
  }
  /// Two have collided.
  void have_collided(BodyId a, BodyId b, Tick tick, double gap_m) {
    recent_.note(a, b, tick, gap_m);
  }
  bool contacts_matter() const { return recent_.enabled(); }
  /// Ends all searches. From now on they may, or may not, leave out pairs that stay near places in
  /// which they are clear of each other (near_places.h).
  void forget_searches(bool use_places);

  /// The body whose search gave up first, and when; none if none did.
  struct GaveUp {
    BodyId body;
    Tick tick{};
  };
  const std::optional<GaveUp>& gave_up() const { return gave_up_; }

 private:
  /// A body may keep its place.
  void note_place(BodyId body);
  /// Whether the hulls of two bodies of several parts are apart; `examined` is then the look's
  /// result for each pair of parts.
  bool hulls_apart(BodyId a, BodyId b, Tick tick, double touch_m, SeparationCache& cache,
                   Examined& examined);
  /// Until when two bodies don't collide again, unless they come faster or closer (tolerances.h).
  Refractory refractory_of_parts(BodyId a, BodyId b);
  Refractory refractory_of_spheres(BodyId a, BodyId b) const;
  Prediction predict_spheres(BodyId a, BodyId b, Tick from) const;
  template <bool k_fresh>
  bool predict_flight_from(BodyId body, const PairEdges& edges,
                           std::span<const std::uint32_t> changes, Tick now) const;
  void gives_up(BodyId body, Tick tick) {
    if (!gave_up_) gave_up_ = GaveUp{body, tick};
  }
  /// What the search found that came to the event, if that was the last one to find a collision.
  /// `other`: a body, or static geometry with its mark.
  const PieceContact* found_contact(BodyId body, std::uint32_t other, const EventKey& event) const {
    const bool same = found_.tick == event.tick && found_.body == body && found_.other == other &&
                      found_.feature == event.feature;
    return same ? &found_.contact : nullptr;
  }

  Bodies& bodies_;
  const MetStatics& statics_;
  PieceSearches searches_;
  RecentContacts recent_;
  NearPlaces places_;
  /// The last look at two hulls: each pair of parts asks for it.
  struct HullLook {
    Tick tick{-1};
    BodyId a{};
    BodyId b{};
    double touch_m = 0;
    bool apart = false;
    Examined examined;
  };
  HullLook hull_look_;
  /// How two parts collide that a search found to do so: the collision mostly comes next. Void
  /// once a body begins a segment.
  struct Found {
    Tick tick{-1};
    BodyId body{};
    std::uint32_t other = 0;  ///< a body, or static geometry, marked with k_static
    std::uint32_t feature = 0;
    PieceContact contact;
  };
  Found found_;
  std::optional<GaveUp> gave_up_;
  /// What predict_flight needs of the axes: beyond `half_m` the nearest image is another; it is at
  /// one period if the distance is within `sure_m` of `middle_m`.
  struct Images {
    Lanes period_m{};
    Lanes half_m = Lanes::all(std::numeric_limits<double>::infinity());
    Lanes middle_m{};
    Lanes sure_m{};
  };
  Images images_;
};

}  // namespace sleight::physics
