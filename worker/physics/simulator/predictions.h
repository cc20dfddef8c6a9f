// Predicts when bodies meet each other and static geometry.
//
// Invariants
//   1. Every prediction depends only on the segments of the bodies involved and on a pair's recent
//      contacts, not on the caller or the time of the call.
//   2. The contact that a search found equals, bit for bit, the one computed at the event.
// Predictions don't use queues or bounding volumes. Thread safety: none.
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
  /// Borrows both arguments. `contacts_matter`: pairs that have just met collide only at smaller
  /// gaps.
  Predictions(Bodies& bodies, const MetStatics& statics, bool contacts_matter);
  Predictions(const Predictions&) = delete;
  Predictions& operator=(const Predictions&) = delete;

  // Two bodies. `search` identifies the state of a search between convex pieces; it is allocated
  // when first needed and released by end_search.
  /// Predicts when the pair collides next, given the two segments. REQUIRES: a < b; the pair has no
  /// event between the start of the later segment and `now`.
  Prediction predict(BodyId a, BodyId b, Tick now, std::uint32_t& search);
  /// Continues a prediction that was not certain. REQUIRES: its tick is `now`.
  Prediction look(BodyId a, BodyId b, Tick now, std::uint32_t search);
  void end_search(std::uint32_t& search) { searches_.release(search); }
  /// Like predict(), but for the periodic image that collides first; used by the algorithm without
  /// boxes. REQUIRES: the world is periodic.
  Prediction predict_any_image(BodyId a, BodyId b, Tick now) const;
  bool touching(BodyId a, BodyId b, Tick tick);

  // Spheres in flight (flight_predictions.cpp).
  /// Whether both bodies are spheres in flight in a scene without slow contacts. Such pairs have a
  /// closed form.
  bool free_spheres(BodyId a, BodyId b) const {
    return bodies_.flight(a).radius_m > 0 && bodies_.flight(b).radius_m > 0 && !recent_.enabled();
  }
  /// Whether predict_flight accepts this body.
  bool in_free_flight(BodyId body) const {
    return bodies_.flight(body).radius_m > 0 && !recent_.enabled();
  }
  /// Closed form for two spheres. In a periodic world, the closed form applies to the image nearest
  /// at `now`. REQUIRES: free_spheres(a, b); a < b.
  Prediction predict_free_spheres(BodyId a, BodyId b, Tick now) const;
  /// Closed form for b's image at a given shift.
  Prediction predict_free_spheres_at(BodyId a, BodyId b, const Vec3& shift_m) const;
  /// Does the same as predict_free_spheres(), for some edges of a body at once. `changes`: change
  /// numbers of all bodies. Returns false if some partners are not in free flight: their edges are
  /// predicted as not colliding, and the caller must predict these edges again. REQUIRES:
  /// in_free_flight(body).
  bool predict_flight(BodyId body, const PairEdges& edges, std::span<const std::uint32_t> changes,
                      Tick now) const;

  // A body and static geometry.
  Prediction predict_static(BodyId body, StaticId met, Tick now, std::uint32_t& search, Tick until);
  Prediction look_static(BodyId body, StaticId met, Tick now, std::uint32_t search, Tick until);

  // Contacts at a predicted event.
  PieceContact contact_at(BodyId a, BodyId b, const EventKey& event);
  PieceContact static_contact_at(BodyId body, StaticId met, const EventKey& event);

  // Notifications about bodies.
  /// Call when a body has moved to another place or changed its motion.
  void moved() {
    found_.tick = Tick{-1};
    hull_look_.tick = Tick{-1};
  }
  /// Call when a body has begun a segment.
  void began(BodyId body) {
    if (places_.enabled()) note_place(body);
  }
  /// Call when two bodies have collided.
  void have_collided(BodyId a, BodyId b, Tick tick, double gap_m) {
    recent_.note(a, b, tick, gap_m);
  }
  bool contacts_matter() const { return recent_.enabled(); }
  /// Ends all searches. `use_places`: later searches may skip pairs that stay near places in which
  /// they are clear of each other (near_places.h).
  void forget_searches(bool use_places);

  /// The body whose search failed first, and when; empty if none failed.
  struct GaveUp {
    BodyId body;
    Tick tick{};
  };
  const std::optional<GaveUp>& gave_up() const { return gave_up_; }

 private:
  /// Registers a body's segment with places_.
  void note_place(BodyId body);
  /// Whether the hulls of two bodies with several parts are apart. If the hulls are apart,
  /// `examined` is the result for each pair of parts.
  bool hulls_apart(BodyId a, BodyId b, Tick tick, double touch_m, SeparationCache& cache,
                   Examined& examined);
  /// Refractory time of two bodies: they don't collide again unless they come faster or closer
  /// (tolerances.h).
  Refractory refractory_of_parts(BodyId a, BodyId b);
  Refractory refractory_of_spheres(BodyId a, BodyId b) const;
  Prediction predict_spheres(BodyId a, BodyId b, Tick from) const;
  template <bool k_fresh>
  bool predict_flight_from(BodyId body, const PairEdges& edges,
                           std::span<const std::uint32_t> changes, Tick now) const;
  void gives_up(BodyId body, Tick tick) {
    if (!gave_up_) gave_up_ = GaveUp{body, tick};
  }
  /// Returns the contact that the search found for this event, if that search was the last to find
  /// a collision. `other`: a body, or static geometry marked with k_static.
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
  /// Result of the last test of two hulls, which each pair of parts uses.
  struct HullLook {
    Tick tick{-1};
    BodyId a{};
    BodyId b{};
    double touch_m = 0;
    bool apart = false;
    Examined examined;
  };
  HullLook hull_look_;
  /// Contact of the last collision that a search of two parts found; it is usually the next event.
  /// The contact is void once a body begins a segment.
  struct Found {
    Tick tick{-1};
    BodyId body{};
    std::uint32_t other = 0;  ///< a body, or static geometry marked with k_static
    std::uint32_t feature = 0;
    PieceContact contact;
  };
  Found found_;
  std::optional<GaveUp> gave_up_;
  /// Data of each axis for predict_flight(). Beyond `half_m`, another image is nearest. That image
  /// is one period away if the distance is within `sure_m` of `middle_m`.
  struct Images {
    Lanes period_m{};
    Lanes half_m = Lanes::all(std::numeric_limits<double>::infinity());
    Lanes middle_m{};
    Lanes sure_m{};
  };
  Images images_;
};

}  // namespace sleight::physics
