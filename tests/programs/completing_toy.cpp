// Program for test_completion.py: the unit tests' toy command line, and its completion scripts.
// Listing jobs fails if NO_SERVER is set.
#include <cstdio>
#include <cstdlib>
#include <string>

#include "clients/command_tree/completion.h"
#include "tests/unit/clients/command_tree/toy_app.h"

int main(int argc, char** argv) {
  using namespace sleight::command_tree;
  const std::string command = argc > 1 ? argv[1] : "";
  const std::string word = argc > 2 ? argv[2] : "";
  if (command == "list" && word == "--complete") {
    if (std::getenv("NO_SERVER") != nullptr) {
      std::fputs("no server\n", stderr);
      return 12;
    }
    std::fputs("17\trunning: hi.toml\n18\tqueued: it's for 18:00\n", stdout);
    return 0;
  }
  ToyArguments arguments;
  CLI::App app;
  build_toy(app, arguments);
  const Command tree = tree_of(app);
  if (command != "completion") return 2;
  std::fputs((word == "bash"  ? bash_completion(tree)
              : word == "zsh" ? zsh_completion(tree)
                              : fish_completion(tree))
                 .c_str(),
             stdout);
  return 0;
}
