// Goal: the command tree has everything that the help shows, and nothing hidden. Method: compare a
// toy program's tree with its definition. test_completion.py in tests/programs runs the completion
// scripts.
#include "clients/command_tree/command_tree.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/clients/command_tree/toy_app.h"

namespace sleight::command_tree {
namespace {

using testing::ElementsAre;

Command toy() {
  ToyArguments arguments;
  CLI::App app;
  build_toy(app, arguments);
  return tree_of(app);
}

TEST(CommandTree, HasCommandsWithoutThoseHidden) {
  const Command tree = toy();
  std::vector<std::string> paths;
  for (const Place& place : places_of(tree))
    paths.push_back(joined(place.words, ' '));
  EXPECT_THAT(paths,
              ElementsAre("toy", "toy run", "toy archive", "toy archive export", "toy wait"));
}

TEST(CommandTree, CutsFooters) {
  const Command tree = toy();
  EXPECT_EQ(tree.summary, "Toy does nothing: it is here for tests. And for no more.");
  EXPECT_THAT(tree.paragraphs, ElementsAre("`toy COMMAND --help` helps."));
  EXPECT_EQ(tree.exit_codes, "0 done; 1 a bug; 130 interrupted.");
  EXPECT_THAT(tree.examples, ElementsAre());
  const Command& run = tree.commands[0];
  EXPECT_THAT(run.paragraphs, ElementsAre(".Goes on where it stopped. Twice."));
  EXPECT_THAT(run.examples, ElementsAre("toy run x.toml -o 'a b.h5'", "toy run \\ -o x.h5"));
  // If a command has no footer, the tree has no footer for it, although its help shows the
  // program's footer.
  EXPECT_EQ(tree.commands[1].exit_codes, "");
}

TEST(CommandTree, HasOptions) {
  const Command run = toy().commands[0];
  ASSERT_EQ(run.options.size(), 4U);
  EXPECT_THAT(run.options[0].names, ElementsAre("-h", "--help"));
  EXPECT_TRUE(run.options[0].is_flag());
  const Argument& output = run.options[1];
  EXPECT_THAT(output.names, ElementsAre("-o", "--output"));
  EXPECT_EQ(output.type_name, "OUTPUT.h5");
  EXPECT_TRUE(output.required);
  EXPECT_FALSE(output.repeats);
  EXPECT_EQ(output.help, "The archive's place");
  EXPECT_EQ(run.options[2].type_name, "N");
  EXPECT_THAT(run.options[2].choices, ElementsAre());
  EXPECT_TRUE(run.options[3].repeats);
  ASSERT_EQ(run.positionals.size(), 1U);
  EXPECT_EQ(run.positionals[0].name, "request");
  EXPECT_THAT(run.positionals[0].names, ElementsAre());
  EXPECT_FALSE(run.positionals[0].required);
}

TEST(CommandTree, KnowsWhatCompletesAValue) {
  const Command tree = toy();
  const Command& run = tree.commands[0];
  const Command& table = tree.commands[1].commands[0];
  EXPECT_EQ(run.positionals[0].completes(), Completes::files);
  EXPECT_THAT(run.positionals[0].suffixes(), ElementsAre(".toml"));
  EXPECT_EQ(run.options[2].completes(), Completes::nothing);
  EXPECT_EQ(run.options[3].completes(), Completes::nothing);
  EXPECT_EQ(table.options[1].completes(), Completes::choices);
  EXPECT_THAT(table.options[1].choices, ElementsAre("posterior", "stats"));
  EXPECT_EQ(table.options[1].fallback, "stats");
  EXPECT_EQ(tree.commands[2].positionals[0].completes(), Completes::jobs);
  EXPECT_TRUE(tree.commands[2].positionals[0].repeats);

  const auto of_type = [](const char* name) {
    Argument argument;
    argument.type_name = name;
    return argument;
  };
  EXPECT_EQ(of_type("FOLDER").completes(), Completes::folders);
  EXPECT_EQ(of_type("NAME.h5.run").completes(), Completes::folders);
  EXPECT_EQ(of_type("PIPE").completes(), Completes::files);
  EXPECT_THAT(of_type("PIPE").suffixes(), ElementsAre());
  EXPECT_EQ(of_type("FILE.svg|FILE.png").completes(), Completes::files);
  EXPECT_THAT(of_type("FILE.svg|FILE.png").suffixes(), ElementsAre(".svg", ".png"));
  EXPECT_EQ(of_type("TIME").completes(), Completes::nothing);
}

}  // namespace
}  // namespace sleight::command_tree
