// A toy command line. It has every kind of option, and words that scripts must quote.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace sleight::command_tree {

struct ToyArguments {
  std::string text;
  std::string table = "stats";
  std::vector<std::string> several;
  bool flag = false;
  int number = 0;
};

inline void build_toy(CLI::App& app, ToyArguments& a) {
  app.name("toy");
  app.description("Toy does nothing: it is\nhere for tests. And for no more.");
  app.require_subcommand(1);
  app.footer("`toy COMMAND --help` helps.\n\nExit codes: 0 done; 1 a bug;\n130 interrupted.");
  app.add_flag("-v,--verbose", a.flag, "More on stderr");

  CLI::App* run = app.add_subcommand("run", "Run a request");
  run->add_option("request", a.text, "The request")->type_name("REQUEST.toml");
  run->add_option("-o,--output", a.text, "The archive's place")->required()->type_name("OUTPUT.h5");
  run->add_option("-n", a.number, "How many: [a] number")->check(CLI::Range(1, 5))->type_name("N");
  run->add_option("--set", a.several, "A key")->allow_extra_args(false)->type_name("KEY=VALUE");
  run->add_flag("--secret", a.flag, "Not for people")->group("");
  run->footer(
      ".Goes on where it stopped. Twice.\n\nExamples:\n  toy run x.toml -o 'a b.h5'\n"
      "  toy run \\ -o x.h5");

  CLI::App* archive = app.add_subcommand("archive", "Look into an archive");
  archive->require_subcommand(1);
  CLI::App* table = archive->add_subcommand("export", "A table as CSV");
  table->add_option("archive", a.text, "The archive")->required()->type_name("ARCHIVE.h5");
  table->add_option("--table", a.table, "Which one")
      ->check(CLI::IsMember({"posterior", "stats"}))
      ->capture_default_str()
      ->type_name("TABLE");

  app.add_subcommand("wait", "Wait for jobs")
      ->add_option("job", a.several, "Jobs")
      ->required()
      ->type_name("JOB");
  app.add_subcommand("man", "Not for people")->group("");
}

}  // namespace sleight::command_tree
