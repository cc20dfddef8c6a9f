#include "tests/statistical/mutants/islands/island_mistakes.h"

namespace sleight::statistical {

const std::vector<IslandMutant<Mistake>>& island_mutants() {
  static const std::vector<IslandMutant<Mistake>> all{
      {Mistake::choice_weight_left_out, "choice_weight_left_out", z_is_right,
       "Z is that of the guide's choices, not of the prior's"},
      {Mistake::potential_of_another_prefix, "potential_of_another_prefix", z_is_right,
       "after a resampling, the old potential that is taken off belongs to another walker"},
      {Mistake::potential_never_taken_off, "potential_never_taken_off", z_is_right,
       "Z has the potentials of all stages in it, not p_c alone"},
      {Mistake::potential_stays_at_the_end, "potential_stays_at_the_end", z_is_right,
       "Z has the potential of the last stage but one in it, besides p_c"},
      {Mistake::temperature_forgotten, "temperature_forgotten", conditional_keeps,
       "draws have p_c where they should have its square"},
      {Mistake::resampled_keep_weights, "resampled_keep_weights", z_is_right,
       "weights count twice: in the number of descendants, and in their weights"},
      {Mistake::mean_weight_left_out, "mean_weight_left_out", z_is_right,
       "Z lacks all that came before the last resampling"},
      {Mistake::resampled_by_squares, "resampled_by_squares", z_is_right,
       "heavy walkers get more descendants than their weights, which are then forgotten"},
      {Mistake::dead_left_out_of_the_mean, "dead_left_out_of_the_mean", z_is_right,
       "Z is that of walkers that go on, as if none had died"},
      {Mistake::dead_islands_made_again, "dead_islands_made_again", z_is_right,
       "Z is that of islands that live, as if none had died"},
      {Mistake::stages_share_numbers, "stages_share_numbers", z_is_right,
       "a walker's choices all come from one uniform number, so they hang together"},
      {Mistake::rescued_left_out, "rescued_left_out", z_is_right,
       "Z is that of the states that a potential of 0 leaves within reach"},
      {Mistake::constraint_left_in_satisfied, "constraint_left_in_satisfied", satisfied_is_right,
       "satisfying states weigh by p_w p_c, not by p_w"},
      {Mistake::satisfied_are_counted, "satisfied_are_counted", satisfied_is_right,
       "particles have been drawn by promise, so their share isn't that of the prior"},
      {Mistake::satisfied_without_earlier_weights, "satisfied_without_earlier_weights",
       satisfied_is_right, "P lacks all that came before the last resampling"},
      {Mistake::drawn_without_weights, "drawn_without_weights", draws_are_weighed,
       "light particles are drawn as often as heavy ones"},

      {Mistake::retained_drawn_anew, "retained_drawn_anew", conditional_keeps,
       "the next state is a free island's draw: right for many particles only"},
      {Mistake::retained_resampled_away, "retained_resampled_away", conditional_keeps,
       "the given path goes on from another walker's prefix"},
      {Mistake::retained_put_over_another, "retained_put_over_another", conditional_keeps_rescued,
       "a light path doesn't make its own point on the circle: it takes another walker's place"},
      {Mistake::retained_weighs_one, "retained_weighs_one", conditional_keeps,
       "the present state is kept as often whether it is heavy or light"},
      {Mistake::retained_never_drawn, "retained_never_drawn", conditional_keeps,
       "heavy states are left as often as light ones"},
      {Mistake::ground_drawn_anew, "ground_drawn_anew", conditional_keeps,
       "a path's choices are told on a ground that they don't belong to"},

      {Mistake::every_island_accepted, "every_island_accepted", independence_keeps,
       "draws are those of single islands, which overrate what small islands find"},
      {Mistake::accepted_by_the_draw, "accepted_by_the_draw", independence_keeps,
       "the ratio of p_c is that of proposals from the prior; draws are better already"},
      {Mistake::rejected_island_gives_z, "rejected_island_gives_z", independence_keeps,
       "the state is left by a Z that another path was drawn from"},
      {Mistake::stale_z_of_a_free_island, "stale_z_of_a_free_island",
       independence_keeps_among_moves,
       "the present state was no such island's draw: islands given it have a larger Z on average"},
      {Mistake::stale_z_kept, "stale_z_kept", independence_keeps_among_moves,
       "a state that a local move found is left by the Z of the state before"},
      {Mistake::fresh_island_spared, "fresh_island_spared", conditional_keeps_among_moves,
       "only states that local moves have just found are left: a step chosen by the state"},
      {Mistake::unreachable_state_leaves, "unreachable_state_leaves",
       independence_keeps_among_moves, "islands lead away from states that they never lead to"},
      {Mistake::guide_learns_from_the_chain, "guide_learns_from_the_chain", visits_keep,
       "the guide hangs on the present state: from a state without a fall none with one is "
       "reached"},
      {Mistake::start_of_a_search_counts, "start_of_a_search_counts", starts_do_not_count,
       "a search finds satisfying states only, and in no proportions"}};
  return all;
}

const std::vector<IslandMutant<PoolMistake>>& pool_mutants() {
  static const std::vector<IslandMutant<PoolMistake>> all{
      {PoolMistake::pool_weight_left_out, "pool_weight_left_out", pool_z_is_right,
       "Z is that of drops as the guide chooses them"},
      {PoolMistake::unused_drops_counted, "unused_drops_counted", pool_given_z_is_right,
       "S over the unused drops alone would be their mean; s has made up for the used ones "
       "already"},
      {PoolMistake::guess_left_in, "guess_left_in", pool_z_is_right,
       "promising drops are chosen more often, and nothing takes that back"},
      {PoolMistake::part_left_out, "part_left_out", pool_satisfied_is_right,
       "balls take part more often than in the prior"},
      {PoolMistake::prior_weight_left_out, "prior_weight_left_out", pool_z_is_right,
       "drops have the density of the pool, not of the prior"},
      {PoolMistake::drop_used_twice, "drop_used_twice", pool_conditional_keeps,
       "two balls at one drop of the pool share one draw of q: equal spots are too likely"},
      {PoolMistake::walk_count_left_out, "walk_count_left_out", pool_satisfied_is_right,
       "a stratum of which a drop is used has too few left, and nothing makes up for it"},
      {PoolMistake::used_drops_in_the_sum, "used_drops_in_the_sum", pool_independence_keeps,
       "S counts drops that can't be chosen: later balls weigh too much"},
      {PoolMistake::stratum_used_up, "stratum_used_up", pool_satisfied_is_right,
       "with fewer drops than balls, three balls by one stratum's drops never are"},
      {PoolMistake::retained_stands_first, "retained_stands_first", pool_conditional_keeps,
       "given drops stand where they would seldom be drawn: the rest of the pool is not what goes "
       "with them"},
      {PoolMistake::retained_not_in_the_pool, "retained_not_in_the_pool", pool_conditional_keeps,
       "the given path has other drops than the given state"},
      {PoolMistake::retained_drops_share_a_place, "retained_drops_share_a_place",
       pool_conditional_keeps, "a later given drop may overwrite an earlier one"}};
  return all;
}

}  // namespace sleight::statistical
