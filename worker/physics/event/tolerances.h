// The named constants of the simulator's model, each with its size and what breaks when it is
// changed. They decide trajectories, what rests and when a simulation gives up, so a change of one
// changes every run.
//
// Other constants of worker/physics stand where they are used:
//   - Search margins, rounding allowances and sizes of structures change only speed, and margins
//     how late a late collision is (piece_motion.h). The margin that all searches share is here:
//     k_rounding_ulps.
//   - Orders, steps and stopping tests of numerical methods change last digits, and so trajectories
//     (motion/, distance/, contact/force_balance.cpp).
//   - Limits of what a scene may contain change which scenes are refused
//     (simulator/scene_check.cpp, scene/friction_map.h, shape/). The one that two checks share is
//     here: k_coordinate_m_max.
//   - Ticks are in tick.h.
// A scene chooses SlowContacts (scene/scene.h); "the slowest bounces" part at its
// separation_speed_mps.
//
// Sizes assume SI units and bodies of 1 mm to 10 m that move at up to some 100 m/s in a scene of up
// to 1 km: a double then carries positions to 1e-13 m.
#pragma once

#include <cstddef>
#include <cstdint>

#include "worker/physics/event/tick.h"

namespace sleight::physics {

// ---- touching and approach ----------------------------------------------------------------------

/// A pair touches when its gap is at most this. It keeps bodies apart by more than they move in one
/// tick (1e-7 m at 100 m/s), so a collision is noticed before they overlap and the closest features
/// are those of separate bodies. Below 1e-9, fast bodies overlap for a tick; above 1e-5, one sees
/// things float.
inline constexpr double k_touch_m = 1e-7;

/// A touching pair collides when it approaches faster than this. Two touching bodies that don't
/// collide may sink into each other at this speed: 1e-7 m in 100 s. At 1e-13 the sign of the speed
/// is rounding noise; at 1e-6, bodies sink visibly.
inline constexpr double k_approach_mps = 1e-9;

/// How much later than a whole simulated step a search may look at the next tick: bounds on gaps
/// are lowered by this many units in the last place of the coordinates, for the rounding of the gap
/// at the skipped ticks. Too small, and two searches may disagree by a tick.
inline constexpr double k_rounding_ulps = 64 * 0x1p-53;

/// Two pieces that touch are looked at again before any of their points can have come so much
/// nearer along the normal, at the speed that it has now: whatever takes over from what touches
/// now, a collision is late by no more. Larger, and such pieces overlap by more; smaller, and pairs
/// in touch take more looks.
inline constexpr double k_touching_depth_m = 1e-6;

/// Round pieces that touch are looked at again after this at the latest, 15 us. Larger, and what
/// speeds up meanwhile comes nearer than k_touching_depth_m; at half of it, a search gives up after
/// half the time in touch, 7.6 s (k_examined_ticks_max).
inline constexpr double k_touching_s_max = 0x1p-16;

/// Where slow contacts end (scene.h), a pair that has collided does not collide again for so long,
/// unless it has come half of the way to the depth k_sink_m since: a body that others squeeze would
/// bounce between them without time passing (inelastic collapse). A pair that approaches at 0.05
/// m/s uses up half of k_touch_m in it.
inline constexpr TickCount k_refractory = TickCount{1} << 10;  // 0.95 us

/// Bodies that approach faster than this collide at once all the same: the blows of a squeeze get
/// slower soon, and this one would sink them by more than 5e-11 m in a tick.
inline constexpr double k_fast_approach_mps = 0.05;

/// Squeezed bodies overlap by hardly more than this, unless one is a hundred times heavier than the
/// other. At 0 the gaps of pairs that are squeezed for long shrink to rounding, and then each tick
/// has its collision; 1e-9 m is what bodies move in a tick at 1 m/s anyway.
inline constexpr double k_sink_m = 5e-10;

/// Squeezed bodies come nearer by at least half of this between two collisions. Smaller than the
/// rounding of distances, at coordinates of some metres, and each tick has its collision.
inline constexpr double k_sink_step_m_min = 2e-14;

// ---- bounces ------------------------------------------------------------------------------------

/// After so many collisions of a body at one tick, its further ones there are plastic: no
/// restitution and no least separation speed. Free bodies collide once or twice at a tick, a cradle
/// of n balls n times.
inline constexpr std::uint32_t k_elastic_at_a_tick = 64;

/// A sphere that rolls leaves an edge or a resting body with this part of the separation speed.
/// Less than other bounces have, as it is paid from its rolling: larger, and balls roll less far.
inline constexpr double k_hop_share = 0.25;

/// A sphere that has met another body stays on nothing for the time of so many of its slowest
/// bounces. At 0 nothing parts the two.
inline constexpr double k_bounces_alone = 4;

/// An impact of rigid bodies may gain this part of their energy, by the rounding of twists.
/// Smaller, and more impulses are reduced than gain energy; larger, and heaps gain some.
inline constexpr double k_impact_rounding = 0x1p-50;
/// The first reduction of an impulse that gains more, and by how much it grows from round to round.
/// The last of the rounds takes off a quarter; if that was not enough, the impact is unresolved.
inline constexpr double k_impact_reduction_first = 0x1p-47;
inline constexpr double k_impact_reduction_growth = 8;
inline constexpr int k_impact_reduction_rounds = 16;

// ---- what stays on static geometry --------------------------------------------------------------

/// A sphere faster than so many times its slowest bounces hops over an edge or a vertex. Smaller,
/// and slow spheres hop too; larger, and fast ones are held to edges.
inline constexpr double k_edge_speeds = 16;

/// A slower sphere rises above the edge or vertex by this part of the height of its slowest
/// bounces: in pieces (edge_motion.h), or straight on before it falls back. Larger, and one sees it
/// fly; smaller, and the way round an edge has more pieces.
inline constexpr double k_rise_bounces = 0.5;

/// A sphere that accelerates into a face by less than this doesn't press on it: over an hour, less
/// than gravity in a tick. At 0 rounding decides what carries it.
inline constexpr double k_press_mps2 = 1e-12;

/// Two faces whose normals have a sine below this, or a cosine below that, are no valley: the one
/// is too flat to say along which line it runs, the other a slit of less than 0.8 degrees, which
/// presses on a sphere with more than seventy times its weight.
inline constexpr double k_valley_sine_min = 1e-3;
inline constexpr double k_valley_cosine_min = -0.9999;

/// A body that is no sphere stays on what is flat only if all that carries it bounces by no more
/// than so many times the slowest bounces. Larger, and it hangs higher above the plane; smaller,
/// and it bounces for longer before it stays.
inline constexpr double k_settling_bounces = 2;

/// Such a body is let go, and caught again where it touches, when it is deeper than this in what is
/// flat: a lying pin sinks by some 1e-8 m/s while it rolls. Smaller, and it is let go more often.
inline constexpr double k_sunk_m = 5e-7;

/// Maximum corners that carry such a body; if more are near, some all around. With few, a body that
/// lies on a face of many corners tips about chords of it.
inline constexpr std::size_t k_plane_supports_max = 64;

/// Maximum length of a segment in which such a body turns unevenly (0.25 s). Larger, and bounds on
/// its turning, which hold for this long, are wider; smaller, and there are more events.
inline constexpr TickCount k_turning_contact_span = TickCount{1} << 28;

/// Friction is asked for again no sooner than after so long: what is driven to a border from both
/// sides, as a sphere that spins up a slope to where it is slippery, would meet it ever faster.
/// Larger, and it has the wrong friction for longer.
inline constexpr TickCount k_border_ticks = 256;  // 0.24 us

// ---- slips --------------------------------------------------------------------------------------

/// A slip is over when it is slower than this part of the slowest bounces. Smaller, and a slip that
/// is pulled from the side turns ever faster as it dies, in some thirty pieces; larger, and slides
/// stop early.
inline constexpr double k_stick_bounces = 0.1;
/// And in any case when it is slower than this: slides end at a whole tick, some 1e-8 m/s after the
/// slip was 0.
inline constexpr double k_stick_mps = 1e-6;

/// The direction of a slip may turn by so much before the motion is asked for again, at least. The
/// square of it is the part of the slip that goes wrong; smaller, and there are more events.
inline constexpr double k_slip_turn_rad = 1.0 / 32;
/// And up to so much, as long as the slip errs by less than k_slip_error_mps or, if that is more,
/// by an eighth of a slip that is over or by a 1024th of the slip.
inline constexpr double k_slip_turn_rad_max = 0.5;
inline constexpr double k_slip_error_mps = 1e-5;
/// It is asked for again after so many times the time in which friction alone would stop the slip:
/// a direction held for longer would swing about the one in which the slip becomes steady.
inline constexpr double k_slip_stops = 4;
/// A slip that would turn by less than this until it ends is straight. At 0 rounding cuts it into
/// pieces.
inline constexpr double k_slip_straight = 1e-9;

/// In a valley, a contact that begins to slip does so for at least this long in a direction that is
/// not quite its own, if its own isn't found. Larger, and friction acts askew for longer; smaller,
/// and more events.
inline constexpr double k_slip_begin_s = 1e-4;
/// Rounds in which that direction is sought, how well it is found, and rounds over both contacts,
/// where each turns the other's direction. With fewer rounds it is found more rarely.
inline constexpr int k_slip_begin_rounds = 40;
inline constexpr double k_slip_begin_off = 1e-12;
inline constexpr int k_slip_both_rounds = 8;

/// Loads and accelerations in contact are rounding below this part of the load. Smaller than the
/// rounding of sums of products, and what slides straight turns, or loses supports.
inline constexpr double k_load_rounding = 1e-12;

// ---- pieces of motion round an edge -------------------------------------------------------------

/// Sine of half of a piece's angle: beyond that the plane half way is no longer like the cylinder.
inline constexpr double k_edge_piece_sine_max = 0.2;
/// A piece that is shorter, as a part of the distance from the edge, is not worth an event: the
/// sphere goes straight on.
inline constexpr double k_edge_piece_sine_min = 1e-4;
/// The first piece tried, of the longest that may do. Larger, and more first tries fail; smaller,
/// and there are more pieces.
inline constexpr double k_edge_piece_first = 0.85;
/// How often a piece is tried, shorter each time, before the sphere goes straight on.
inline constexpr int k_edge_piece_tries_max = 4;
/// The part of the square of its speed that a piece may turn outwards. Larger, and pieces begin
/// more steeply.
inline constexpr double k_edge_piece_turned_max = 0.25;
/// A piece is at most twice this part of the way to where the sphere turns back. At 0.5, what is
/// left is too short for a piece.
inline constexpr double k_edge_piece_before_turn = 0.4;

// ---- bodies that lie on a plane -----------------------------------------------------------------

/// The shortest and the longest piece in which slips turn. Larger, and slips turn by more in a
/// piece; smaller, and there are more events.
inline constexpr double k_slide_piece_s_min = 0x1p-11;
inline constexpr double k_slide_piece_s_max = 0x1p-7;
/// The longest piece where one support hardly slips while others do: its friction is uncertain.
inline constexpr double k_slip_uncertain_s = 0x1p-10;
/// Maximum halvings of a piece in which friction would do work; then the body is let go.
inline constexpr int k_slide_halvings_max = 2;
/// Friction is less where a slip is slower than this part of one that is over: a support that
/// sticks while others slip would swing. Where all are as slow, the body sticks.
inline constexpr double k_full_friction_slip = 0.25;
/// A spin that moves no support faster than this part of a slip that is over doesn't count. At 0 a
/// body that slides straight turns by what its last bounce has left.
inline constexpr double k_no_spin_slip = 0.01;

/// A body of revolution whose axis is nearer to the normal than this sine lies on no line.
inline constexpr double k_line_sine_min = 0.1;
/// Supports lie on a line if they are within this part of their distance from the centre. Smaller
/// than rounding, and a lying cylinder doesn't roll; larger, and narrow faces are lines.
inline constexpr double k_line_width = 1e-6;
/// What lies on a line from which its axis rises by less than this is a cylinder, and rolls
/// straight on. Above it is a cone, and rolls in a circle.
inline constexpr double k_cylinder_rise_max = 1e-3;
/// A plane is level for what rolls if it is pulled along by less than this part of the load. At 0 a
/// cylinder creeps, and no cone rolls, by rounding.
inline constexpr double k_level_pull = 1e-9;
/// A piece of the circle of what rolls as a cone. It takes longer than it would by a 12th of its
/// square, 8e-5; so the axis keeps up with the line about which it rolls, and its inclination, to
/// 1e-9 rad in a piece (64 times as much in one of twice the angle).
inline constexpr double k_cone_piece_rad = 1.0 / 32;

// ---- rest: who is slow --------------------------------------------------------------------------

/// Slow bounces part at the separation speed, or up to so many times as fast. Larger, and bodies
/// freeze in the air; at 1, rounding decides which bounces are slow.
inline constexpr double k_slow_parting = 2;
/// So many slow collisions without a fast one, in the time of a few slow bounces, stand for any
/// rest time: a body that is jammed between others collides without time passing. Fewer, and bodies
/// that still settle count as jammed.
inline constexpr std::uint32_t k_slow_collisions = 256;
inline constexpr double k_jam_bounces = 5;
/// So many times as many stand for balance with others as well.
inline constexpr std::uint32_t k_jams_anyhow = 16;
/// A body that stands, but not firmly, rests after so many rest times. The tilt of a cube on its
/// edge grows e-fold in 0.97 sqrt(size / g), its moment about the edge over its weight: some
/// 700-fold meanwhile where the rest time is 0.1 sqrt(size / g). Smaller, and it rests on its edge;
/// larger, and what leans on others bounces for longer.
inline constexpr TickCount k_patience = 64;

// ---- rest: who is held --------------------------------------------------------------------------

/// Contacts that a body remembers; of more, the oldest go. With few, a body that stands on many is
/// not in balance. 32 at most: sets of them are bits.
inline constexpr std::size_t k_touch_records_max = 16;
static_assert(k_touch_records_max <= 32);
/// A newer contact takes the place of one with the same partner that is closer to it than this part
/// of the arm. Larger, and two corners count as one; smaller, and one that wanders fills the list.
inline constexpr double k_same_place = 0.05;
/// A corner this close to what its body has just touched carries as well, as a part of the body's
/// reach. A body that stands on three corners, two of which carry nearly all of it, lifts the third
/// by some fifty times the height of a bounce, and would not be in balance for most of the time.
/// Larger, and corners in the air carry.
inline constexpr double k_near_corner = 0.003;
/// Such corners carry only where both touch the same face: normals this much alike. Smaller, and
/// the next face of a blunt body counts too.
inline constexpr double k_same_face_cosine = 0.98;
/// Maximum points that carry a box on a spline surface: the outermost in as many directions.
inline constexpr std::size_t k_surface_points_max = 8;

/// Balance may miss by this part of the weight. Larger, and bodies rest that would topple or slide;
/// smaller, and rounding and bounces keep them awake.
inline constexpr double k_balance_tolerance = 0.002;
/// A body stands firmly if it would with its centre so far to any side, as a part of its reach: a
/// cube that stands on an edge does not. Larger, and a body on a narrow base rests only after
/// k_patience.
inline constexpr double k_firm = 0.003;
static_assert(k_firm > k_balance_tolerance);  // else a cube on its edge, off by that, is firm
/// Sweeps over all pushes in the search for balance, and after how many each it is judged whether
/// the search gets anywhere. With fewer sweeps, bodies in balance are taken not to be.
inline constexpr int k_balance_sweeps_max = 400;
inline constexpr int k_balance_sweeps_judged = 8;

/// Each body of a larger structure that comes to rest is held by itself, whatever lies on it. The
/// search for forces takes milliseconds for 32 bodies, a second for hundreds.
inline constexpr std::size_t k_held_together_max = 32;
/// Rounds of that search, and after how many each it is judged, as sweeps are.
inline constexpr int k_held_rounds_max = 8192;
inline constexpr int k_held_rounds_judged = 64;
/// In a set that isn't held, those that miss so much of what the worst of them misses don't rest.
/// Smaller, and those that could rest without the worst stay awake with it.
inline constexpr double k_misses_much = 0.5;

/// What starts at rest may be so far above what carries it, or overlap it by so much. Smaller, and
/// places that people compute don't touch; larger, and one sees bodies hang.
inline constexpr double k_at_rest_gap_m = 1e-6;
/// A force between two such bodies that leans to the side by more than this part of itself is one
/// that both need, as in an arch: each is the other's supporter. Larger, and a stone near an arch's
/// foot sleeps on when the one above it goes; smaller, and those of a column wake then, too.
inline constexpr double k_thrust_share = 0.05;
/// Forces between them below this part of the weight carry nothing.
inline constexpr double k_carries_share = 1e-3;

// ---- waking -------------------------------------------------------------------------------------

/// A body wakes from a blow that would give it this many times the speed below which it rests: more
/// than slow neighbours can. Smaller, and these wake it; larger, and it takes up more momentum.
inline constexpr double k_wake_over_rest = 4;
/// A body at rest bears blows that push it as hard as so many times its weight. It carries less in
/// most heaps. Larger, and a wall takes up the momentum of a ball that presses into it.
inline constexpr double k_bears_gravities = 16;
/// A body that woke, or stays, is in its place as long as it has moved by less than this part of
/// its reach. Larger, and what lies on it rests in the air; smaller, and a blow wakes whole heaps.
inline constexpr double k_in_place = 0.005;

// ---- limits -------------------------------------------------------------------------------------

/// Places, planes and sizes in a scene are no further from 0. Sums of squares of larger coordinates
/// lose the places that collisions need.
inline constexpr double k_coordinate_m_max = 1e6;

/// Maximum bodies that start at rest and hang together (k_held_together_max says what more cost).
inline constexpr std::size_t k_at_rest_together_max = 256;

/// Draws of a start's place before the simulation fails.
inline constexpr std::uint32_t k_start_attempts_max = 1000;

/// Ticks that one search may examine before it gives up with a typed error: a search takes some
/// tens; a million means that a bound is wrong.
inline constexpr std::uint32_t k_examined_ticks_max = 1'000'000;

/// Collisions of one body in a window of 2^20 ticks (1 ms) before the simulation gives up with a
/// typed error: a ball that bounces ever lower, in a scene that doesn't say how slow contacts end.
/// Settling bodies have some thousands.
inline constexpr std::uint32_t k_collisions_in_window_max = 200'000;
inline constexpr TickCount k_window = TickCount{1} << 20;

/// Events of one body at one tick before the simulation gives up with a typed error.
inline constexpr std::uint32_t k_events_at_a_tick_max = 10'000;

/// Events that a decision about rest counts as in a simulation of marbles whose work is limited.
inline constexpr std::uint64_t k_rest_work = 4;

}  // namespace sleight::physics
