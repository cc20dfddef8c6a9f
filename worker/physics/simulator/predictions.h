// Predicts when bodies meet each other and static geometry.
//
// Invariants
//   1. Every prediction depends only on the bodies' segments and the pair's recent contacts, not on
//      the caller or the time of the call.
//   2. If a search has found a contact, it equals the contact computed at the event, bit for bit.
// Predictions don't use queues or bounding volumes. Thread safety: none.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>

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
  /// Borrows both arguments. `contacts_matter`: if a pair has just met, it collides again only at a
  /// smaller gap.
  Predictions(Bodies& bodies, const MetStatics& statics, bool contacts_matter);
  Predictions(const Predictions&) = delete;
  Predictions& operator=(const Predictions&) = delete;

  // Two bodies. `search` identifies the state of a search between convex pieces. The first call
  // that needs this state allocates it; end_search() releases it.
  /// Predicts when the pair collides next. REQUIRES: a < b; from the start of the later segment
  /// until `now`, the pair has no event.
  Prediction predict(BodyId a, BodyId b, Tick now, std::uint32_t& search);
  /// Continues a prediction that was not certain. REQUIRES: its tick is `now`.
  Prediction look(BodyId a, BodyId b, Tick now, std::uint32_t search);
  void end_search(std::uint32_t& search) { searches_.release(search); }
  /// Predicts which periodic image of b collides first, and when. The algorithm without boxes uses
  /// it. REQUIRES: the world is periodic.
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
  /// Closed form for two spheres. In a periodic world, predicts the image that is nearest at `now`.
  /// REQUIRES: free_spheres(a, b); a < b.
  Prediction predict_free_spheres(BodyId a, BodyId b, Tick now) const;
  /// Closed form for b's image that is shifted by `shift_m`.
  Prediction predict_free_spheres_at(BodyId a, BodyId b, const Vec3& shift_m) const;
  /// Equals predict_free_spheres(), but predicts several edges of a body at once. `changes`: change
  /// numbers of all bodies. Returns false if some partners are not in free flight. The caller must
  /// predict their edges again: they have been predicted as not colliding. REQUIRES:
  /// in_free_flight(body).
  bool predict_flight(BodyId body, const PairEdges& edges, std::span<const std::uint32_t> changes,
                      Tick now) const;

  // A body and static geometry.
  Prediction predict_static(BodyId body, StaticId met, Tick now, std::uint32_t& search, Tick until);
  Prediction look_static(BodyId body, StaticId met, Tick now, std::uint32_t search, Tick until);

  // Contacts at a predicted event.
  PieceContact contact_at(BodyId a, BodyId b, const EventKey& event);
  PieceContact static_contact_at(BodyId body, StaticId met, const EventKey& event);
  /// Speed at which the pair of a collision approaches along the contact normal (collision_rule.h).
  double approach_mps(const EventKey& event);

  // Notifications about bodies.
  /// Call when a body has moved to another place or changed its motion.
  void moved() {
    found_.tick = Tick{-1};
    hull_look_.tick = Tick{-1};
  }
  void began(BodyId body) {
    if (places_.enabled()) note_place(body);
  }
  void have_collided(BodyId a, BodyId b, Tick tick, double gap_m) {
    // A fixed body may have more recent partners than `recent_` can store, so its partner stores
    // the contact.
    if (bodies_.is_fixed(a)) std::swap(a, b);
    recent_.note(a, b, tick, gap_m);
  }
  bool contacts_matter() const { return recent_.enabled(); }
  /// Ends all searches. `use_places`: later searches may skip a pair while its bodies stay near
  /// places in which they can't touch (near_places.h).
  void forget_searches(bool use_places);

  /// Returns which body's search failed first, and when. Empty if no search failed.
  struct GaveUp {
    BodyId body;
    Tick tick{};
  };
  const std::optional<GaveUp>& gave_up() const { return gave_up_; }

 private:
  /// Registers a body's segment with places_.
  void note_place(BodyId body);
  /// Whether two bodies' hulls are apart. If the hulls are apart, `examined` is the result for each
  /// pair of parts.
  bool hulls_apart(BodyId a, BodyId b, Tick tick, double touch_m, SeparationCache& cache,
                   Examined& examined);
  /// During their refractory time, two bodies collide again only if they approach faster or come
  /// closer (tolerances.h).
  Refractory refractory_of(BodyId a, BodyId b) const {
    return bodies_.is_fixed(a) ? recent_.of(b, a) : recent_.of(a, b);
  }
  Refractory refractory_of_parts(BodyId a, BodyId b);
  Refractory refractory_of_spheres(BodyId a, BodyId b) const;
  Prediction predict_spheres(BodyId a, BodyId b, Tick from) const;
  template <bool k_fresh>
  bool predict_flight_from(BodyId body, const PairEdges& edges,
                           std::span<const std::uint32_t> changes, Tick now) const;
  void gives_up(BodyId body, Tick tick) {
    if (!gave_up_) gave_up_ = GaveUp{body, tick};
  }
  /// Returns the contact that a search found for this event, or null if another search has found a
  /// collision since. `other`: a body, or static geometry marked with k_static.
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
  /// Result of the last test of two hulls; all pairs of parts use this result.
  struct HullLook {
    Tick tick{-1};
    BodyId a{};
    BodyId b{};
    double touch_m = 0;
    bool apart = false;
    Examined examined;
  };
  HullLook hull_look_;
  /// The last collision that a search of two parts found, usually the next event. The contact
  /// becomes void when any body begins a segment.
  struct Found {
    Tick tick{-1};
    BodyId body{};
    std::uint32_t other = 0;  ///< a body, or static geometry marked with k_static
    std::uint32_t feature = 0;
    PieceContact contact;
  };
  Found found_;
  std::optional<GaveUp> gave_up_;
  /// Data of each axis for predict_flight(). If a distance is above `half_m`, another image is
  /// nearer. If the distance also is within `sure_m` of `middle_m`, that image is exactly one
  /// period away.
  struct Images {
    Lanes period_m{};
    Lanes half_m = Lanes::all(std::numeric_limits<double>::infinity());
    Lanes middle_m{};
    Lanes sure_m{};
  };
  Images images_;
};

}  // namespace sleight::physics
