// Goal: each mistake in what is uncertain, in regions and in constraints gets one error with its
// place. Method: compare the errors of bad requests with the expected ones.
#include <gtest/gtest.h>

#include "tests/unit/worker/worlds/user_scene/read_scene.h"

namespace sleight::worlds::user_scene {
namespace {

struct DirectionMistake {
  std::string text;   ///< behind the scene; its first line is line 18
  std::string error;  ///< behind the file's name
};

class SceneDirectionMistake : public testing::TestWithParam<DirectionMistake> {};

constexpr const char* k_scene = R"([world]
name = "scene"
[[world.body]]
name = "floor"
shape = "plane"
[[world.body]]
name = "ball"
radius_mm = 5
at_mm = [0, 0, 100]
row = {count = 2, step_mm = [50, 0, 0]}
[[world.body]]
name = "box"
shape = "box"
size_mm = [10, 20, 30]
at_mm = [0, 100, 15]
rests = true
group = "pins"
)";

TEST_P(SceneDirectionMistake, HasOneErrorWithItsPlace) {
  const auto request = read_scene(k_scene + GetParam().text);
  ASSERT_FALSE(request.ok());
  std::string errors;
  for (const request::Diagnostic& diagnostic : request.error())
    errors += to_string(diagnostic) + "\n";
  EXPECT_EQ(errors, "s.toml:" + GetParam().error + "\n");
}

std::string uncertain(const std::string& keys) {
  return "[[world.uncertain]]\n" + keys;
}
std::string constraint(const std::string& kind, const std::string& keys) {
  return "[[constraint." + kind + "]]\n" + keys;
}
const std::string k_cup =
    "[[world.region]]\nname = \"cup\"\nlow_mm = [0, 0, 0]\nhigh_mm = [50, 50, 50]\n";

const std::vector<DirectionMistake> k_direction_mistakes{
    {uncertain("body = \"ball\"\n"),
     "18:1: 'quantity' in [[world.uncertain]]: missing; expected one of \"position_mm\", "
     "\"velocity_mps\", \"spin_radps\", \"turn_deg\", \"orientation\", \"start_s\", \"presence\", "
     "\"radius_mm\", \"size_mm\", \"density_kgpm3\", \"restitution\", \"friction\", "
     "\"rolling_friction\""},
    {uncertain("body = \"ball\"\nquantity = \"place_mm\"\nnormal_sd = [1, 1, 1]\n"),
     "20:12: 'quantity' in [[world.uncertain]]: expected one of \"position_mm\", "
     "\"velocity_mps\", \"spin_radps\", \"turn_deg\", \"orientation\", \"start_s\", \"presence\", "
     "\"radius_mm\", \"size_mm\", \"density_kgpm3\", \"restitution\", \"friction\", "
     "\"rolling_friction\", found the string \"place_mm\""},
    {uncertain("quantity = \"position_mm\"\nnormal_sd = [1, 1, 1]\n"),
     "19:1: 'quantity' in [[world.uncertain]]: needs the key body or bodies, and no material"},
    {uncertain("body = \"bal\"\nquantity = \"position_mm\"\nnormal_sd = [1, 1, 1]\n"),
     "19:1: 'body' in [[world.uncertain]]: no body is named \"bal\"; did you mean \"ball\"?"},
    {uncertain("body = \"ball 3\"\nquantity = \"position_mm\"\nnormal_sd = [1, 1, 1]\n"),
     "19:1: 'body' in [[world.uncertain]]: no body is named \"ball 3\"; did you mean \"ball 1\"?"},
    {uncertain("body = \"floor\"\nquantity = \"position_mm\"\nnormal_sd = [1, 1, 1]\n"),
     "19:1: 'body' in [[world.uncertain]]: \"floor\" never moves"},
    {uncertain("body = \"ball\"\nbodies = [\"box\"]\nquantity = \"position_mm\"\nnormal_sd = [1, "
               "1, 1]\n"),
     "20:1: 'bodies' in [[world.uncertain]]: set either body or bodies, not both"},
    {uncertain(
         "bodies = [\"ball\", \"ball 1\"]\nquantity = \"position_mm\"\nnormal_sd = [1, 1, 1]\n"),
     "19:1: 'bodies' in [[world.uncertain]]: \"ball 1\" is named twice"},
    {uncertain("body = \"ball\"\nquantity = \"position_mm\"\n"),
     "18:1: 'normal_sd' in [[world.uncertain]]: missing; give normal_sd, within or choices, "
     "so that position_mm is uncertain"},
    {uncertain("body = \"ball\"\nquantity = \"position_mm\"\nnormal_sd = [0, 0, 0]\n"),
     "21:1: 'normal_sd' in [[world.uncertain]]: must not be all 0; give normal_sd, within or "
     "choices, "
     "so that position_mm is uncertain"},
    {uncertain("body = \"ball\"\nquantity = \"position_mm\"\nnormal_sd = [1]\n"),
     "21:1: 'normal_sd' in [[world.uncertain]]: expected 3 numbers for position_mm, found 1"},
    {uncertain("body = \"ball\"\nquantity = \"position_mm\"\nnormal_sd = [1, -1, 1]\n"),
     "21:17: 'normal_sd' in [[world.uncertain]]: element 2: expected a number from 0 to 1000000, "
     "found -1"},
    {uncertain("body = \"ball\"\nquantity = \"position_mm\"\nnormal_sd = [1, nan, 1]\n"),
     "21:17: 'normal_sd' in [[world.uncertain]]: element 2: expected a number from 0 to 1000000, "
     "found nan"},
    {uncertain("body = \"ball\"\nquantity = \"radius_mm\"\nchoices = [5, 0]\n"),
     "21:1: 'choices' in [[world.uncertain]]: expected numbers from 0.01 to 1e+06 for radius_mm, "
     "found 0"},
    {uncertain("body = \"ball\"\nquantity = \"radius_mm\"\nchoices = [5, 6]\nshares = [1]\n"),
     "22:1: 'shares' in [[world.uncertain]]: expected 2 shares, one for each choice, found 1"},
    {uncertain("body = \"ball\"\nquantity = \"radius_mm\"\nchoices = [5, 6]\nwithin = [1]\n"),
     "21:1: 'choices' in [[world.uncertain]]: set either choices, or normal_sd and within"},
    {uncertain("body = \"ball\"\nquantity = \"position_mm\"\nchoices = [5, 6]\n"),
     "21:1: 'choices' in [[world.uncertain]]: expected 3 numbers for each choice of position_mm, "
     "found 2 numbers"},
    {uncertain("body = \"box\"\nquantity = \"radius_mm\"\nnormal_sd = [1]\n"),
     "20:1: 'quantity' in [[world.uncertain]]: is for a sphere, but \"box\" is a box"},
    {uncertain("body = \"ball\"\nquantity = \"size_mm\"\nnormal_sd = [1, 1, 1]\n"),
     "20:1: 'quantity' in [[world.uncertain]]: is for a box, but \"ball 1\" is a sphere"},
    {uncertain("body = \"box\"\nquantity = \"presence\"\nprobability = 0.5\n"),
     "20:1: 'quantity' in [[world.uncertain]]: \"box\" starts at rest, so it is always there"},
    {uncertain("body = \"ball\"\nquantity = \"presence\"\n"),
     "18:1: 'probability' in [[world.uncertain]]: missing; presence needs it"},
    {uncertain("body = \"ball\"\nquantity = \"presence\"\nprobability = 1.5\n"),
     "21:15: 'probability' in [[world.uncertain]]: expected a number above 0 and at most 1, found "
     "1.5"},
    {uncertain("body = \"ball\"\nquantity = \"start_s\"\nwithin = [1]\nprobability = 0.5\n"),
     "22:1: 'probability' in [[world.uncertain]]: start_s has no such key; remove it"},
    {uncertain("body = \"ball\"\nquantity = \"orientation\"\nnormal_sd = [1]\n"),
     "21:1: 'normal_sd' in [[world.uncertain]]: orientation has no such key; remove it"},
    {uncertain("body = \"ball\"\nquantity = \"friction\"\nnormal_sd = [0.1]\n"),
     "20:1: 'quantity' in [[world.uncertain]]: needs the key material, and neither body nor "
     "bodies"},
    {uncertain("material = \"glass\"\nquantity = \"friction\"\nnormal_sd = [0.1]\n"),
     "19:1: 'material' in [[world.uncertain]]: no material is named \"glass\"; the names are "
     "\"default\""},
    {uncertain("material = \"default\"\nquantity = \"spin_radps\"\nnormal_sd = [1, 1, 1]\n"),
     "20:1: 'quantity' in [[world.uncertain]]: needs the key body or bodies, and no material"},
    {uncertain("body = \"ball\"\nquantity = \"orientation\"\n") +
         uncertain("body = \"ball 2\"\nquantity = \"turn_deg\"\nwithin = [1, 1, 1]\n"),
     "23:1: 'quantity' in [[world.uncertain]]: is already uncertain for \"ball 2\" (see line 18)"},
    {k_cup + k_cup, "23:1: 'name' in [[world.region]]: another region is already named \"cup\""},
    {"[[world.region]]\nname = \"cup\"\nlow_mm = [0, 0, 0]\n",
     "18:1: 'high_mm' in [[world.region]]: missing; a region needs it"},
    {"[[world.region]]\nname = \"cup\"\nlow_mm = [0, 0, 9]\nhigh_mm = [5, 5, 5]\n",
     "21:1: 'high_mm' in [[world.region]]: must be at least low_mm along each axis"},
    {k_cup + constraint("region", "body = \"ball\"\nregion = \"cap\"\nsigma_mm = 1\n"),
     "24:1: 'region' in [[constraint.region]]: no region or static body is named \"cap\"; did "
     "you mean \"cup\"?"},
    {k_cup + constraint("region", "body = \"ball\"\nregion = \"cup\"\n"),
     "22:1: 'sigma_mm' in [[constraint.region]]: missing; expected a number from 1e-6 to 1000000 "
     "mm"},
    {k_cup + constraint("region", "region = \"cup\"\nsigma_mm = 1\n"),
     "22:1: 'body' in [[constraint.region]]: missing; set body or bodies"},
    {k_cup + constraint("region", "body = \"ball\"\nregion = \"cup\"\nsigma_mm = 1\nat_s = 20\n"),
     "26:1: 'at_s' in [[constraint.region]]: is after end_s of [world], 10 s"},
    {constraint("place", "body = \"ball\"\nat_mm = [0]\nsigma_mm = 1\n"),
     "20:9: 'at_mm' in [[constraint.place]]: expected 2 to 3 numbers, each a number from -1000000 "
     "to 1000000 mm, found an array of 1"},
    {constraint("place", "body = \"ball 1\"\nat_mm = [0, 0]\nsigma_mm = 1\n") +
         constraint("place", "body = \"ball 1\"\nat_mm = [9, 0]\nsigma_mm = 1\ntolerance_mm = 2\n"),
     "23:1: 'body' in [[constraint.place]]: contradicts the constraint in line 18: the places are "
     "9 mm apart, but the tolerances add up to 2 mm"},
    {constraint("face", "body = \"box\"\n"),
     "18:1: 'up' in [[constraint.face]]: set either up or axis"},
    {constraint("face", "body = \"box\"\nup = 7\n"),
     "20:6: 'up' in [[constraint.face]]: expected an integer from 1 to 6, found 7"},
    {constraint("face", "body = \"box\"\nup = 1\n") +
         constraint("face", "body = \"box\"\nup = 6\n"),
     "22:1: 'body' in [[constraint.face]]: contradicts the constraint in line 18: the two "
     "directions are 180 degrees apart"},
    {constraint("stands", "body = \"box\"\n") + constraint("topples", "body = \"box\"\n"),
     "19:1: 'body' in [[constraint.stands]]: contradicts the constraint in line 20: a body can't "
     "stand and topple"},
    {k_cup + constraint("count", "group = \"pens\"\nregion = \"cup\"\n"),
     "23:1: 'group' in [[constraint.count]]: no moving body has the group \"pens\""},
    {k_cup + constraint("count", "group = \"pins\"\nregion = \"cup\"\nat_least = 2\n"),
     "25:1: 'at_least' in [[constraint.count]]: the group has only 1 moving bodies"},
    {constraint("event", "body = \"ball 1\"\nat_s = 1\nsigma_s = 0.1\ntolerance_s = 0.1\n"),
     "18:1: 'hits' in [[constraint.event]]: missing; expected a string of at most 64 characters"},
    {constraint("event", "body = \"ball 1\"\nhits = \"flor\"\n"),
     "20:1: 'hits' in [[constraint.event]]: no body is named \"flor\"; did you mean \"floor\"?"},
    {constraint("event", "body = \"ball 1\"\nhits = \"floor\"\nat_s = 1\ntolerance_s = 0.1\n"),
     "18:1: 'sigma_s' in [[constraint.event]]: missing; an event with a time needs it"},
    {constraint("event", "body = \"ball 1\"\nhits = \"floor\"\nat_s = 1\nsigma_s = 0.1\n"),
     "18:1: 'tolerance_s' in [[constraint.event]]: missing; an event at a time needs it"},
    {constraint(
         "event",
         "body = \"ball 1\"\nhits = \"floor\"\nat_s = 11\nsigma_s = 0.1\ntolerance_s = 0.1\n"),
     "21:1: 'at_s' in [[constraint.event]]: is after end_s of [world], 10 s"},
    {constraint("event",
                "body = \"ball 1\"\nhits = \"floor\"\nat_s = 1\nframe = 5\nsigma_s = "
                "0.1\ntolerance_s = 0.1\n"),
     "21:1: 'at_s' in [[constraint.event]]: set only one of at_s, frame, beats_s, and the range "
     "before_s, after_s"},
    {constraint("event",
                "body = \"ball 1\"\nhits = \"floor\"\nbefore_s = 1\nafter_s = 2\nsigma_s = 0.1\n"),
     "21:1: 'before_s' in [[constraint.event]]: must be at least after_s"},
    {constraint("event", "name = \"a\"\nbody = \"ball 1\"\nhits = \"floor\"\n") +
         constraint("event", "name = \"a\"\nbody = \"ball 2\"\nhits = \"floor\"\n"),
     "23:1: 'name' in [[constraint.event]]: another constraint is already named \"a\""},
    {constraint("event", "name = \"a\"\nbody = \"ball 1\"\nhits = \"floor\"\n") +
         constraint("order", "events = [\"a\", \"b\"]\nsigma_s = 0.1\n"),
     "23:1: 'events' in [[constraint.order]]: no event is named \"b\"; the names are \"a\""},
    {constraint("event", "body = \"ball 1\"\nhits = \"floor\"\n") +
         constraint("never", "body = \"ball 1\"\nhits = \"floor\"\n"),
     "22:1: 'body' in [[constraint.never]]: contradicts the constraint in line 18: the one asks "
     "for a hit that the other forbids"},
    {uncertain("body = \"box\"\nquantity = \"velocity_mps\"\nnormal_sd = [1, 1, 1]\n"),
     "20:1: 'quantity' in [[world.uncertain]]: \"box\" starts at rest, so its speed is 0"},
    {uncertain("body = \"ball\"\nquantity = \"position_mm\"\nwithin = [0, 0, 0]\n"),
     "21:1: 'within' in [[world.uncertain]]: must not be all 0; give normal_sd, within or "
     "choices, so that position_mm is uncertain"},
    {uncertain("body = \"ball\"\nquantity = \"start_s\"\nwithin = [1]\nshares = [1]\n"),
     "22:1: 'shares' in [[world.uncertain]]: belongs to choices, which are missing"},
    {uncertain("body = \"ball\"\nquantity = \"radius_mm\"\nchoices = [5, 6]\nshares = [0, 0]\n"),
     "22:1: 'shares' in [[world.uncertain]]: must not be all 0"},
    {uncertain("body = \"ball\"\nquantity = \"presence\"\nnormal_sd = [1]\n"),
     "21:1: 'normal_sd' in [[world.uncertain]]: presence has no such key; remove it"},
    {uncertain("body = \"ball\"\nquantity = \"presence\"\nprobability = 0\n"),
     "21:15: 'probability' in [[world.uncertain]]: expected a number above 0 and at most "
     "1, found 0"},
    {constraint("region", "body = \"ball\"\nregion = \"floor\"\nsigma_mm = 1\n"),
     "20:1: 'region' in [[constraint.region]]: \"floor\" is a plane, which has no box around "
     "it; name a [[world.region]]"},
    {constraint("face", "body = \"ball\"\nup = 6\n"),
     "20:1: 'up' in [[constraint.face]]: is for boxes, but \"ball 1\" is a sphere; set axis"},
    {constraint("event", "name = \"a\"\nbody = \"ball 1\"\nhits = \"floor\"\n") +
         constraint("order", "events = [\"a\", \"a\"]\nsigma_s = 0.1\n"),
     "23:1: 'events' in [[constraint.order]]: \"a\" is named twice"},
    {constraint("event", "body = \"ball\"\nhits = \"ball 1\"\n"),
     "20:1: 'hits' in [[constraint.event]]: a body can't hit itself; name another body"},
};

INSTANTIATE_TEST_SUITE_P(All, SceneDirectionMistake, testing::ValuesIn(k_direction_mistakes));

}  // namespace
}  // namespace sleight::worlds::user_scene
