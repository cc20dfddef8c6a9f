#include "worker/physics/contact/rest_decision.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "common/math/vector.h"

namespace sleight::physics {

void RestDecision::reset(std::size_t bodies) {
  notes_.resize(bodies);
  set_.reserve(bodies);
  structure_.reserve(bodies);
  overloaded_.reserve(bodies);
  read_.reserve(bodies);
  const std::size_t together = std::min(bodies, k_held_together_max);
  held_bodies_.reserve(together);
  holding_.reserve(together * k_touch_records_max);
  balance_.reserve(together, together * k_touch_records_max);
}

// ---- who is asked about -------------------------------------------------------------------------

// If all candidates together don't carry a body, then no subset of them does.

void RestDecision::begin(RestLogs& logs, BodyId body, Tick now) {
  ++round_;
  logs_ = &logs;
  body_ = body;
  now_ = now;
  asked_of_ = touch_ = 0;
  set_.clear();
  overloaded_.clear();
  read_.clear();
}

std::optional<BodyId> RestDecision::asks() {
  // Start with the body itself, because its answer usually settles the decision.
  if (notes_[body_].round != round_) return body_;
  for (; asked_of_ < set_.size(); ++asked_of_, touch_ = 0) {
    const auto touches = log_of(set_[asked_of_]).touches();
    while (touch_ < touches.size()) {
      const BodyId partner = touches[touch_++].partner;
      if (partner != k_static_partner && !log_of(partner).rests && notes_[partner].round != round_)
        return partner;
    }
    check(set_[asked_of_]);
    if (!notes_[body_].candidate) break;
  }
  return std::nullopt;
}

void RestDecision::tell(BodyId body, const Present& present) {
  RestLog& log = log_of(body);
  log.forget_before(now_, logs_->rest_span);
  const auto is_stayed_on = [&](const TouchRecord& touch) {
    return touch.partner == k_static_partner &&
           std::ranges::find(present.stays_on, touch.feature) != present.stays_on.end();
  };
  Note& note = notes_[body];
  note.round = round_;
  note.speed_mps = present.speed_mps;
  note.centre_m = present.centre_m;
  note.holds = present.stays && present.stands;
  note.slides =
      present.stays && !present.stands && std::ranges::all_of(log.touches(), is_stayed_on);
  note.unheld = false;
  note.candidate = log.count != 0 && log.slow_since != k_never &&
                   (now_ - log.slow_since >= logs_->rest_span || log.is_jammed()) &&
                   note.speed_mps < logs_->rule.rest_speed_mps;
  note_stay(log, note, logs_->bodies[body].reach_m);
  if (note.candidate) set_.push_back(body);
}

RestDecision::Outcome RestDecision::decide() {
  if (!find_set()) {
    ask_later();
    for (const BodyId bearer : overloaded_) {
      // The bearer couldn't bear the body. The bearer rests again only together with this body.
      log_of(bearer).rests = false;
      log_of(bearer).must_bear = body_;
    }
    return {.rest = {}, .wake = overloaded_, .read = read_};
  }
  lay_down_set();
  return {.rest = set_, .wake = {}, .read = read_};
}

bool RestDecision::find_set() {
  if (!notes_[body_].candidate) return false;
  // Nearly always one pass is enough.
  do {
    if (!settle_set()) return false;
  } while (!is_held() && overloaded_.empty());
  return overloaded_.empty();
}

void RestDecision::ask_later() {
  RestLog& log = log_of(body_);
  const Note& note = notes_[body_];
  // A sliding body needs no early test, because it is tested when its sliding changes
  // (Resting::stays). If other bodies can't hold this body, it keeps moving with them for a while.
  const bool unheld = note.unheld || !overloaded_.empty();
  const bool later = unheld || note.slides;
  log.due = now_ + std::max<TickCount>(1, later ? 4 * logs_->rest_span : logs_->rest_span / 2);
  if (log.is_jammed() && !unheld) log.slow_collisions = 0;
  if (note.speed_mps >= logs_->rule.rest_speed_mps) log.disturb();
}

// ---- one body -----------------------------------------------------------------------------------

bool RestDecision::may_lean_on(const TouchRecord& touch) const {
  if (touch.partner == k_static_partner || log_of(touch.partner).rests) return true;
  const Note& other = notes_[touch.partner];
  return other.round == round_ && other.candidate;
}

bool RestDecision::lacks_load(const RestLog& log) const {
  return log.must_bear != k_static_partner &&
         std::ranges::any_of(log.touches(), [&](const TouchRecord& touch) {
           return touch.partner == log.must_bear && !may_lean_on(touch);
         });
}

bool RestDecision::has_been_slow(const RestLog& log) const {
  return log.slow_since <= now_ && (now_ - log.slow_since) / k_patience >= logs_->rest_span;
}

bool RestDecision::has_stayed(const RestLog& log) const {
  return log.stays_since <= now_ && (now_ - log.stays_since) / k_patience >= logs_->rest_span;
}

void RestDecision::note_stay(RestLog& log, const Note& note, double reach_m) const {
  const double moved_m = math::norm(note.centre_m - log.stays_at_m);
  if (note.candidate && log.stays_since <= now_ && log.stays_since >= log.slow_since &&
      moved_m <= k_in_place * reach_m)
    return;
  log.stays_since = note.candidate ? now_ : k_never;
  log.stays_at_m = note.centre_m;
}

bool RestDecision::holds_anyhow(const RestLog& log) const {
  if (log.rests) return log.rests_anyhow;
  return log.slow_collisions >= k_jams_anyhow * k_slow_collisions || has_been_slow(log);
}

bool RestDecision::check(BodyId member) {
  const RestLog& log = log_of(member);
  Note& note = notes_[member];
  note.carried = lacks_load(log) && !has_been_slow(log) ? 0 : supporting(member);
  note.candidate = note.carried != 0;
  return note.candidate;
}

Contacts RestDecision::supporting(BodyId body) const {
  const RestLog& log = log_of(body);
  const Note& note = notes_[body];
  const RestingBody& own = logs_->bodies[body];
  const auto contacts = log.touches();
  if (note.slides && !has_stayed(log)) return 0;
  const bool weightless = is_zero(own.weight_n);
  const auto pushes_up = [&](const TouchRecord& touch) {
    return weightless || math::dot(touch.normal, own.weight_n) < 0;
  };
  // If the body has no weight, is jammed, stands in lasting contact, or has long been in place: use
  // all contacts that may carry it.
  if (weightless || log.is_jammed() || has_stayed(log) || note.holds) {
    Contacts all = 0;
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      if (!pushes_up(contacts[k])) continue;
      if (!may_lean_on(contacts[k])) return 0;
      all |= Contacts{1} << k;
    }
    return all;
  }
  // First try only the contacts that push up, so that a body on top of this one doesn't count as
  // holding it. Then try all contacts. Require firm balance unless the body has been slow for
  // k_patience rest times: in this time, a body without balance would have toppled.
  const bool firmly = !own.round && (now_ - log.slow_since) / k_patience < logs_->rest_span;
  std::array<TouchRecord, k_touch_records_max> chosen;
  std::array<std::size_t, k_touch_records_max> places;
  std::size_t before = 0;
  for (const bool any : {false, true}) {
    std::size_t count = 0;
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      if (!may_lean_on(contacts[k]) || !(any || pushes_up(contacts[k]))) continue;
      chosen[count] = contacts[k];
      places[count++] = k;
    }
    if (count == before) continue;
    before = count;
    const Contacts pushing =
        carrying(std::span(chosen).first(count), own.weight_n, own.reach_m, firmly);
    Contacts result = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if ((pushing >> i & 1U) != 0) result |= Contacts{1} << places[i];
    }
    if (result != 0) return result;
  }
  return 0;
}

// ---- the set ------------------------------------------------------------------------------------

bool RestDecision::settle_set() {
  // Check members again if they lean on a body that isn't carried.
  const auto leans_on_others = [&](BodyId member) {
    const RestLog& log = log_of(member);
    const auto contacts = log.touches();
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      if ((notes_[member].carried >> k & 1U) != 0 && !may_lean_on(contacts[k])) return true;
    }
    return lacks_load(log);
  };
  for (bool again = true; again;) {
    again = false;
    for (const BodyId member : set_) {
      if (notes_[member].candidate && leans_on_others(member) && !check(member)) again = true;
    }
    if (!notes_[body_].candidate) return false;
  }
  std::erase_if(set_, [&](BodyId member) { return !notes_[member].candidate; });
  std::sort(set_.begin(), set_.end());
  return true;
}

bool RestDecision::is_held() {
  // If all members lean only on static geometry, they are already in balance.
  const bool alone = std::ranges::all_of(set_, [&](BodyId member) {
    const RestLog& log = log_of(member);
    return !log.has_place && std::ranges::all_of(log.touches(), [&](const TouchRecord& touch) {
      return logs_->is_fixed(touch.partner) || !may_lean_on(touch);
    });
  });
  if (alone || !find_structure() || balances(structure_.size())) return true;
  if (structure_.size() > set_.size() && balances(set_.size())) {
    for (const BodyId member : std::span(structure_).subspan(set_.size())) {
      if (std::ranges::any_of(set_, [&](BodyId one) {
            return std::ranges::any_of(log_of(one).touches(), [&](const TouchRecord& touch) {
              return touch.partner == member;
            });
          }))
        overloaded_.push_back(member);
    }
    if (!overloaded_.empty()) return false;
  }
  const auto missing = [&](BodyId member) {
    const std::uint32_t place = notes_[member].structure_place;
    return place == HoldingContact::k_fixed ? 0 : balance_.missing(place);
  };
  double most = 0;
  for (const BodyId member : set_)
    most = std::max(most, missing(member));
  for (const BodyId member : set_) {
    if (missing(member) < k_misses_much * most) continue;
    notes_[member].candidate = false;
    notes_[member].unheld = true;
  }
  return false;
}

bool RestDecision::find_structure() {
  // A decision examines another structure each time the set loses members.
  ++structures_;
  structure_.clear();
  const auto add = [&](BodyId member) {
    if (notes_[member].in_structure == structures_) return;
    notes_[member].in_structure = structures_;
    structure_.push_back(member);
  };
  for (const BodyId member : set_)
    add(member);
  const std::vector<RestLog>& logs = logs_->logs;
  for (std::size_t i = 0; i < structure_.size(); ++i) {
    const BodyId member = structure_[i];
    const RestLog& log = logs[member];
    for (const TouchRecord& touch : log.rests ? log.holding() : log.touches()) {
      if (!logs_->is_fixed(touch.partner) && logs[touch.partner].rests) add(touch.partner);
    }
    // Nothing rests on a body that has been moving.
    const bool bears = log.rests || log.has_place;
    for (BodyId other{}; bears && other < logs.size(); ++other) {
      if (logs[other].rests_on(member)) add(other);
    }
    if (structure_.size() > k_held_together_max) return false;
    if (!log.rests) continue;
    notes_[member].centre_m = log.rests_at_m;
    if (std::ranges::find(read_, member) == read_.end()) read_.push_back(member);
  }
  return true;
}

bool RestDecision::balances(std::size_t count) {
  held_bodies_.clear();
  holding_.clear();
  for (std::size_t i = 0; i < structure_.size(); ++i) {
    const BodyId member = structure_[i];
    const RestingBody& body = logs_->bodies[member];
    Note& note = notes_[member];
    note.structure_place = HoldingContact::k_fixed;
    if (i >= count || is_zero(body.weight_n) || holds_anyhow(log_of(member))) continue;
    note.structure_place = static_cast<std::uint32_t>(held_bodies_.size());
    held_bodies_.push_back({.weight_n = body.weight_n, .reach_m = body.reach_m});
  }
  for (const BodyId member : structure_) {
    const RestLog& log = log_of(member);
    const Note& note = notes_[member];
    if (note.structure_place == HoldingContact::k_fixed) continue;
    for (const TouchRecord& touch : log.rests ? log.holding() : log.touches()) {
      if (!log.rests && !may_lean_on(touch)) continue;
      HoldingContact contact{.body = note.structure_place,
                             .friction = touch.friction,
                             .normal = touch.normal,
                             .arm_m = touch.arm_m};
      if (touch.partner != k_static_partner && notes_[touch.partner].in_structure == structures_) {
        const Note& partner = notes_[touch.partner];
        contact.partner = partner.structure_place;
        contact.partner_arm_m = (note.centre_m + touch.arm_m) - partner.centre_m;
      }
      holding_.push_back(contact);
    }
  }
  return balance_.holds(held_bodies_, holding_);
}

void RestDecision::lay_down_set() {
  for (const BodyId member : set_) {
    RestLog& log = log_of(member);
    log.supporter_count = 0;
    log.held_count = 0;
    log.rests_anyhow = holds_anyhow(log);
    const auto contacts = log.touches();
    for (const TouchRecord& touch : contacts) {
      if (may_lean_on(touch)) log.held[log.held_count++] = touch;
    }
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      const BodyId partner = contacts[k].partner;
      if ((notes_[member].carried >> k & 1U) == 0 || logs_->is_fixed(partner) ||
          log.leans_on(partner))
        continue;
      log.supporters[log.supporter_count++] = partner;
    }
  }
  for (const BodyId member : set_) {
    RestLog& log = log_of(member);
    log.disturb();
    log.rests = true;
    log.must_bear = k_static_partner;
    log.in_place = false;
    log.count = 0;
  }
}

}  // namespace sleight::physics
