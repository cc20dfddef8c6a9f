// The named constants of the simulator's model, and the effects of changing them. These constants
// decide trajectories, which bodies rest, and when a simulation gives up. So if a constant changes,
// every run changes.
//
// Other constants of worker/physics are defined where they are used:
//   1. Search margins, rounding allowances and capacities affect only speed. Margins also affect
//      how late a collision may be (piece_motion.h). All searches share k_rounding_ulps, which is
//      here.
//   2. Orders, steps and stopping tests of numerical methods affect last digits of results, and so
//      affect trajectories (motion/, distance/, contact/force_balance.cpp).
//   3. Limits for scenes decide which scenes are refused (simulator/scene_check.cpp,
//      scene/friction_map.h, shape/). Two checks share k_coordinate_m_max, which is here.
//   4. Ticks are in tick.h.
// A scene chooses its SlowContacts (scene/scene.h). "The slowest bounces" separate at
// separation_speed_mps.
//
// Values assume SI units, bodies of 1 mm to 10 m, speeds of up to about 100 m/s, and scenes of up
// to 1 km. A double then represents positions to 1e-13 m.
#pragma once

#include <cstddef>
#include <cstdint>

#include "worker/physics/event/tick.h"

namespace sleight::physics {

// ---- touching and approach ----------------------------------------------------------------------

/// Maximum gap of a touching pair. In one tick, a body at 100 m/s moves by 1e-7 m. So a collision
/// is noticed before the bodies overlap, and the closest features are those of separate bodies.
/// Below 1e-9, fast bodies overlap for a tick; above 1e-5, bodies visibly float.
inline constexpr double k_touch_m = 1e-7;

/// Minimum approach speed at which a touching pair collides. Touching bodies that don't collide may
/// sink into each other at this speed: 1e-7 m in 100 s. At 1e-13, the speed's sign is rounding
/// noise; at 1e-6, bodies sink visibly.
inline constexpr double k_approach_mps = 1e-9;

/// When a search skips ticks, it lowers bounds on gaps by this many units in the last place of the
/// coordinates, to allow for rounding. If the allowance is too small, two searches may disagree by
/// a tick.
inline constexpr double k_rounding_ulps = 64 * 0x1p-53;

/// If pieces touch, their next collision may be late by this depth. A touching pair is tested again
/// before any of its points, at the current speed, approaches by this depth along the normal. With
/// a larger value, touching pieces overlap by more. With a smaller value, touching pairs are tested
/// more often.
inline constexpr double k_touching_depth_m = 1e-6;

/// Maximum time between tests of touching round pieces, 15 us. With a larger value, accelerating
/// pieces approach by more than k_touching_depth_m. At half this value, a search fails after 7.6 s
/// in touch instead of 15.3 s (k_examined_ticks_max).
inline constexpr double k_touching_s_max = 0x1p-16;

/// Refractory time. For this time after a collision, the pair doesn't collide again, unless the
/// bodies come half of the way to the depth k_sink_m. Applies only if slow contacts end (scene.h).
/// Without this time, a squeezed body would bounce between its neighbours for ever while no time
/// passes (inelastic collapse). A pair that approaches at 0.05 m/s uses up half of k_touch_m in
/// this time.
inline constexpr TickCount k_refractory = TickCount{1} << 10;  // 0.95 us

/// Bodies that approach faster than this collide despite k_refractory. The repeated impacts of
/// squeezed bodies soon get slower than this. At this speed, bodies would sink by more than 5e-11 m
/// per tick.
inline constexpr double k_fast_approach_mps = 0.05;

/// Approximate maximum overlap of squeezed bodies, unless one is a hundred times heavier than the
/// other. At 0, if a pair is squeezed for long, its gap shrinks to the size of rounding errors, and
/// every tick has a collision. Bodies at 1 m/s move by 1e-9 m in a tick anyway.
inline constexpr double k_sink_m = 5e-10;

/// Between two collisions, squeezed bodies approach by at least half of this. At coordinates of
/// some metres, distances have rounding errors. If this value is smaller than these errors, every
/// tick has a collision.
inline constexpr double k_sink_step_m_min = 2e-14;

// ---- bounces ------------------------------------------------------------------------------------

/// After this many collisions at one tick, a body's further collisions at that tick are plastic:
/// they have no restitution and no minimum separation speed. A free body collides once or twice at
/// a tick. A cradle of n balls collides n times.
inline constexpr std::uint32_t k_elastic_at_a_tick = 64;

/// Speed at which a rolling sphere hops off an edge or off a resting body, as a share of the
/// separation speed. The hop is slower than other bounces because its energy comes from the
/// rolling. With a larger value, balls roll less far.
inline constexpr double k_hop_share = 0.25;

/// After a sphere has met another body, it doesn't stay on anything for some time: the duration of
/// this many slowest bounces. At 0, nothing separates the sphere from the other body.
inline constexpr double k_bounces_alone = 4;

/// Relative gain of energy that rounding of twists may cause in an impact of rigid bodies. With a
/// smaller value, impulses that gain no energy are reduced too. With a larger value, heaps gain
/// energy.
inline constexpr double k_impact_rounding = 0x1p-50;
/// If an impulse gains more energy than k_impact_rounding, it is reduced in rounds. The first round
/// reduces it by this share, and the share grows from round to round. The last round removes a
/// quarter of the impulse. If that isn't enough, the impact is unresolved.
inline constexpr double k_impact_reduction_first = 0x1p-47;
inline constexpr double k_impact_reduction_growth = 8;
inline constexpr int k_impact_reduction_rounds = 16;

// ---- what stays on static geometry --------------------------------------------------------------

/// A sphere hops over an edge or a vertex if it is faster than this many times the speed of its
/// slowest bounces. With a smaller value, slow spheres also hop. With a larger value, fast spheres
/// are held to edges.
inline constexpr double k_edge_speeds = 16;

/// A slower sphere moves in pieces (edge_motion.h), or straight on before it falls back. The sphere
/// rises above the edge or vertex by this share of the height of its slowest bounces. With a larger
/// value, the sphere visibly flies. With a smaller value, the path round an edge has more pieces.
inline constexpr double k_rise_bounces = 0.5;

/// If a sphere's acceleration into a face is less than this, the sphere doesn't press on the face.
/// In an hour, such an acceleration adds less speed than gravity adds in a tick. At 0, rounding
/// decides which features carry a sphere.
inline constexpr double k_press_mps2 = 1e-12;

/// Two faces form no valley if their normals have a sine or a cosine below these limits. If the
/// sine is too small, the valley is too flat to define the line along which it runs. If the cosine
/// is too small, the valley is a slit of less than 0.8 degrees. Such a slit would press on a sphere
/// with more than seventy times the sphere's weight.
inline constexpr double k_valley_sine_min = 1e-3;
inline constexpr double k_valley_cosine_min = -0.9999;

/// A body that isn't a sphere stays on a flat surface only if none of the points that carry it
/// bounces faster than this many times the slowest bounces. With a larger value, the body hovers
/// higher above the plane. With a smaller value, the body bounces for longer before it stays.
inline constexpr double k_settling_bounces = 2;

/// If a body on a flat surface sinks deeper than this, it is released, and caught again where it
/// touches. A lying pin sinks at about 1e-8 m/s while it rolls. With a smaller value, bodies are
/// released more often.
inline constexpr double k_sunk_m = 5e-7;

/// Maximum number of corners that carry a body on a flat surface. If more corners are near the
/// surface, some are selected on all sides. If this number is small, a body that lies on a face
/// with many corners tips about chords of the face.
inline constexpr std::size_t k_plane_supports_max = 64;

/// Maximum duration of a segment in which a body in contact rotates unevenly (0.25 s). Bounds on
/// the rotation hold for this time. With a larger value, these bounds are wider. With a smaller
/// value, there are more events.
inline constexpr TickCount k_turning_contact_span = TickCount{1} << 28;

/// Minimum time between changes of a body's friction. Without this minimum, a body that is driven
/// to a border from both sides would meet the border at ever shorter intervals. For example, a
/// sphere's spin may drive it up a slope to a slippery part. With a larger value, the body has the
/// wrong friction for longer.
inline constexpr TickCount k_border_ticks = 256;  // 0.24 us

// ---- slips --------------------------------------------------------------------------------------

/// A slip ends when its speed is below this share of the speed of the slowest bounces. With a
/// smaller value, a slip that is pulled sideways turns ever faster before it ends, through some
/// thirty pieces of motion. With a larger value, slides stop early.
inline constexpr double k_stick_bounces = 0.1;
/// A slip also ends below this absolute speed. A slide ends at a whole tick, so at its end the slip
/// may have passed 0 by about 1e-8 m/s.
inline constexpr double k_stick_mps = 1e-6;

/// Angle by which a slip's direction may turn before the motion is recomputed. The slip's relative
/// error is the square of this angle. With a smaller value, there are more events.
inline constexpr double k_slip_turn_rad = 1.0 / 32;
/// The angle may be as large as this while the slip's error is small. The error must be below the
/// greatest of three speeds: k_slip_error_mps, an eighth of the speed at which slips end, and a
/// 1024th of the slip.
inline constexpr double k_slip_turn_rad_max = 0.5;
inline constexpr double k_slip_error_mps = 1e-5;
/// The motion is recomputed after this many times the time in which friction alone would stop the
/// slip. If a direction were held for longer, it would swing about the slip's steady direction.
inline constexpr double k_slip_stops = 4;
/// A slip counts as straight if it turns by less than this before it ends. At 0, rounding splits
/// the slip into pieces.
inline constexpr double k_slip_straight = 1e-9;

/// A contact in a valley begins to slip in an approximate direction if the exact direction isn't
/// found. The contact keeps the approximate direction for at least this time. With a larger value,
/// friction acts in an inexact direction for longer. With a smaller value, there are more events.
inline constexpr double k_slip_begin_s = 1e-4;
/// Limits of the search for the direction in which a slip begins: rounds for one contact,
/// tolerance, and rounds for two contacts. Two contacts need rounds because each contact turns the
/// slip's direction at the other contact. With fewer rounds, the search fails more often.
inline constexpr int k_slip_begin_rounds = 40;
inline constexpr double k_slip_begin_off = 1e-12;
inline constexpr int k_slip_both_rounds = 8;

/// A load or acceleration in contact counts as a rounding error if it is below this share of the
/// load. If this value is below the rounding error of sums of products, a straight slide turns or
/// loses supports.
inline constexpr double k_load_rounding = 1e-12;

// ---- pieces of motion round an edge -------------------------------------------------------------

/// Maximum sine of half of a piece's angle. If the angle is larger, the piece's plane differs too
/// much from the cylinder round the edge.
inline constexpr double k_edge_piece_sine_max = 0.2;
/// Minimum length of a piece, as a share of the distance from the edge. A shorter piece isn't worth
/// an event: the sphere moves straight on.
inline constexpr double k_edge_piece_sine_min = 1e-4;
/// Length of the first piece that is tried, as a share of the longest possible length. With a
/// larger value, more first tries fail. With a smaller value, there are more pieces.
inline constexpr double k_edge_piece_first = 0.85;
/// Maximum tries for a piece before the sphere moves straight on. Each try is shorter than the
/// last.
inline constexpr int k_edge_piece_tries_max = 4;
/// Maximum share of the sphere's squared speed that a piece may turn outwards. With a larger value,
/// pieces begin more steeply.
inline constexpr double k_edge_piece_turned_max = 0.25;
/// A piece covers at most twice this share of the path to the point at which the sphere turns back.
/// At 0.5, the rest of the path is too short for a piece.
inline constexpr double k_edge_piece_before_turn = 0.4;

// ---- bodies that lie on a plane -----------------------------------------------------------------

/// Minimum and maximum duration of a piece of motion in which slips change direction. With larger
/// values, a slip turns by a larger angle within one piece. With smaller values, there are more
/// events.
inline constexpr double k_slide_piece_s_min = 0x1p-11;
inline constexpr double k_slide_piece_s_max = 0x1p-7;
/// Maximum duration of a piece in which one support hardly slips, although others slip. The
/// friction at that support is uncertain.
inline constexpr double k_slip_uncertain_s = 0x1p-10;
/// Maximum number of times that a piece is halved because friction would add energy. After that,
/// the body is released.
inline constexpr int k_slide_halvings_max = 2;
/// If a support slips slower than this share of the speed at which slips end, its friction is
/// reduced. With full friction, a support that sticks while others slip would swing. If all
/// supports are that slow, the body sticks.
inline constexpr double k_full_friction_slip = 0.25;
/// A spin counts as 0 if it moves no support faster than this share of the speed at which slips
/// end. At 0, a body that slides straight would be turned by the spin that is left from its last
/// bounce.
inline constexpr double k_no_spin_slip = 0.01;

/// A body of revolution touches along a line only if the sine of the angle between its axis and the
/// normal is at least this.
inline constexpr double k_line_sine_min = 0.1;
/// Supports count as on a line if their distance from it is at most this share of their distance
/// from the centre. With a value below rounding errors, a lying cylinder doesn't roll. With a
/// larger value, narrow faces count as lines.
inline constexpr double k_line_width = 1e-6;
/// Let a body of revolution lie on a line. If its axis rises from the line by less than this, it is
/// a cylinder and rolls straight on. If the axis rises by more, it is a cone and rolls in a circle.
inline constexpr double k_cylinder_rise_max = 1e-3;
/// If a rolling body is pulled along a plane by less than this share of the load, the plane counts
/// as level. At 0, rounding makes cylinders creep and keeps cones from rolling.
inline constexpr double k_level_pull = 1e-9;
/// Angle of a piece of a rolling cone's circle. The piece lasts longer than the exact motion by a
/// share of 8e-5, which is the angle's square over 12. So the axis stays on the line on which the
/// body rolls, and keeps its inclination. The error is 1e-9 rad per piece. With twice the angle,
/// the error is 64 times as large.
inline constexpr double k_cone_piece_rad = 1.0 / 32;

// ---- rest: who is slow --------------------------------------------------------------------------

/// Slow bounces separate at up to this many times the separation speed. With a larger value, bodies
/// freeze in the air. At 1, rounding decides which bounces are slow.
inline constexpr double k_slow_parting = 2;
/// A body is jammed after this many slow collisions within the time of k_jam_bounces slow bounces,
/// if no collision was fast. A jammed body needs no rest time, because it collides without time
/// passing. With a smaller value, bodies that still settle count as jammed.
inline constexpr std::uint32_t k_slow_collisions = 256;
inline constexpr double k_jam_bounces = 5;
/// After this multiple of k_slow_collisions, a body rests even if it isn't in balance with other
/// bodies.
inline constexpr std::uint32_t k_jams_anyhow = 16;
/// A body that stands, but not firmly, rests after this many rest times. The tilt of a cube on its
/// edge grows e-fold in 0.97 sqrt(size / g). If the rest time is 0.1 sqrt(size / g), the tilt grows
/// about 700-fold in 64 rest times. With a smaller value, a cube rests on its edge. With a larger
/// value, bodies that lean on others bounce for longer.
inline constexpr TickCount k_patience = 64;

// ---- rest: who is held --------------------------------------------------------------------------

/// Maximum number of contacts that a body stores. If there are more, the oldest are dropped. With a
/// smaller value, a body that stands on many contacts is not in balance. Values above 32 are
/// impossible, because sets of contacts are stored as bits.
inline constexpr std::size_t k_touch_records_max = 16;
static_assert(k_touch_records_max <= 32);
/// A new contact replaces an old contact with the same partner if their distance is below this
/// share of the arm's length. With a larger value, two corners count as one. With a smaller value,
/// a wandering contact fills the list.
inline constexpr double k_same_place = 0.05;
/// A corner also carries its body if its distance to the thing that the body has just touched is at
/// most this share of the body's reach. For example, let a body stand on three corners, and let two
/// of them carry nearly all of its weight. The body lifts the third corner by some fifty times the
/// height of a bounce. If this corner didn't count, the body would be out of balance most of the
/// time. With a larger value, corners in the air count as carrying.
inline constexpr double k_near_corner = 0.003;
/// Two corners count as on the same face if the cosine between their normals is at least this. With
/// a smaller value, corners on neighbouring faces of a blunt body count as on the same face.
inline constexpr double k_same_face_cosine = 0.98;
/// Maximum number of points that carry a box on a spline surface. The points are the outermost ones
/// in this many directions.
inline constexpr std::size_t k_surface_points_max = 8;

/// Tolerance of balance, as a share of the weight. With a larger value, bodies that should topple
/// or slide come to rest. With a smaller value, rounding and bounces keep bodies awake.
inline constexpr double k_balance_tolerance = 0.002;
/// A body stands firmly if it still stands when its centre is moved to any side by this share of
/// its reach. A cube on its edge does not stand firmly. With a larger value, a body on a narrow
/// base rests only after k_patience.
inline constexpr double k_firm = 0.003;
static_assert(k_firm > k_balance_tolerance);  // otherwise a cube on its edge, off by that, is firm
/// Limits of the search for balance: maximum number of sweeps over all pushes, and number of sweeps
/// between progress checks. With fewer sweeps, some balanced bodies are not recognized.
inline constexpr int k_balance_sweeps_max = 400;
inline constexpr int k_balance_sweeps_judged = 8;

/// Maximum number of bodies in a structure that is balanced as a whole. In a larger structure, each
/// body that comes to rest is tested alone, without the load on it. The search for forces takes
/// milliseconds for 32 bodies, and a second for hundreds.
inline constexpr std::size_t k_held_together_max = 32;
/// Limits of the search for forces: maximum number of rounds, and number of rounds between progress
/// checks.
inline constexpr int k_held_rounds_max = 8192;
inline constexpr int k_held_rounds_judged = 64;
/// If forces don't hold a set, each member with at least this share of the greatest imbalance
/// doesn't rest. With a smaller value, more members stay awake, although they could rest if only
/// the worst member stayed awake.
inline constexpr double k_misses_much = 0.5;

/// Maximum gap or overlap between a body that starts at rest and its supporters. With a smaller
/// value, bodies that a person has placed by computing positions don't touch. With a larger value,
/// bodies visibly hover.
inline constexpr double k_at_rest_gap_m = 1e-6;
/// Consider a force between two bodies that start at rest. If its sideways part exceeds this share
/// of the force, both bodies need the force, as in an arch. Each body is then a supporter of the
/// other body. With a larger value, a stone near an arch's foot keeps resting when the stone above
/// it leaves. With a smaller value, a stone in a column also wakes when the stone above it leaves.
inline constexpr double k_thrust_share = 0.05;
/// If a force between bodies that start at rest is below this share of the weight, it carries
/// nothing.
inline constexpr double k_carries_share = 1e-3;

// ---- waking -------------------------------------------------------------------------------------

/// A body wakes if an impact would give it this many times the rest speed. Impacts of slow
/// neighbours can't do this. With a smaller value, slow neighbours wake the body. With a larger
/// value, the body absorbs more momentum.
inline constexpr double k_wake_over_rest = 4;
/// A resting body bears a push of at most this many times its weight. In most heaps, bodies carry
/// less than this. With a larger value, a wall absorbs the momentum of a ball that presses into it.
inline constexpr double k_bears_gravities = 16;
/// A body that woke, or that stays in contact, leaves its place once it has moved by this share of
/// its reach. With a larger value, bodies that rest on such a body are left in the air. With a
/// smaller value, an impact wakes whole heaps.
inline constexpr double k_in_place = 0.005;

// ---- limits -------------------------------------------------------------------------------------

/// Maximum magnitude of positions, plane offsets and sizes in a scene. Sums of squares of larger
/// coordinates lose the digits that collisions need.
inline constexpr double k_coordinate_m_max = 1e6;

/// Maximum number of connected bodies that start at rest. k_held_together_max has the costs.
inline constexpr std::size_t k_at_rest_together_max = 256;

/// Maximum number of times that a body's start is drawn before the simulation fails.
inline constexpr std::uint32_t k_start_attempts_max = 1000;

/// Maximum number of ticks that one search may examine before it gives up with a typed error. A
/// search usually examines some tens of ticks. If it examines a million, a bound is wrong.
inline constexpr std::uint32_t k_examined_ticks_max = 1'000'000;

/// Maximum collisions of one body in a window of 2^20 ticks (1 ms) before the simulation fails with
/// a typed error. A ball that bounces ever lower exceeds this limit if the scene has no
/// SlowContacts. Settling bodies have some thousands.
inline constexpr std::uint32_t k_collisions_in_window_max = 200'000;
inline constexpr TickCount k_window = TickCount{1} << 20;

/// Maximum events of one body at one tick before the simulation fails with a typed error.
inline constexpr std::uint32_t k_events_at_a_tick_max = 10'000;

/// Work of a rest decision, in units of events. Used for the work limit of Marbles.
inline constexpr std::uint64_t k_rest_work = 4;

}  // namespace sleight::physics
