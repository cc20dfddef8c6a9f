// Goal: a manual page has every part of its command, with what troff would take for its own
// escaped. Method: the pages of a toy program, one whole and others by their lines; mandoc judges
// the real ones (tests/programs/test_completion.py).
#include "clients/command_tree/man_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/clients/command_tree/toy_app.h"

namespace sleight::command_tree {
namespace {

using testing::HasSubstr;

std::vector<ManPage> pages() {
  ToyArguments arguments;
  CLI::App app;
  build_toy(app, arguments);
  return man_pages(tree_of(app), "November 26, 2026");
}

TEST(ManPages, ThereIsOneForEachCommand) {
  std::vector<std::string> files;
  for (const ManPage& page : pages())
    files.push_back(page.file);
  EXPECT_THAT(files, testing::ElementsAre("toy.1", "toy-run.1", "toy-archive.1",
                                          "toy-archive-export.1", "toy-wait.1"));
}

TEST(ManPages, OneWhole) {
  EXPECT_EQ(pages()[3].text,
            ".Dd November 26, 2026\n"
            ".Dt TOY-ARCHIVE-EXPORT 1\n"
            ".Os\n"
            ".Sh NAME\n"
            ".Nm toy-archive-export\n"
            ".Nd a table as CSV\n"
            ".Sh SYNOPSIS\n"
            ".Nm \"\\&toy\"\n"
            ".Cm \"\\&archive\"\n"
            ".Cm \"\\&export\"\n"
            ".Op Fl \"\\&\\-table\" Ar \"\\&TABLE\"\n"
            ".Ar \"\\&ARCHIVE.h5\"\n"
            ".Sh DESCRIPTION\n"
            "A table as CSV.\n"
            ".Pp\n"
            "Its arguments are:\n"
            ".Bl -tag -width Ds\n"
            ".It Ar \"\\&ARCHIVE.h5\"\n"
            "The archive.\n"
            ".El\n"
            ".Pp\n"
            "Its options are:\n"
            ".Bl -tag -width Ds\n"
            ".It Fl \"\\&h\" , Fl \"\\&\\-help\"\n"
            "Print this help message and exit.\n"
            ".It Fl \"\\&\\-table\" Ar \"\\&TABLE\"\n"
            "Which one.\n"
            "One of posterior, stats.\n"
            "Default: stats.\n"
            ".El\n"
            ".Sh SEE ALSO\n"
            ".Xr toy 1 ,\n"
            ".Xr toy-archive 1\n");
}

TEST(ManPages, EscapeWhatTroffWouldTakeForItsOwn) {
  const std::string run = pages()[1].text;
  // A sentence a line, and no line that begins with a dot of the text.
  EXPECT_THAT(run, HasSubstr("\n\\&.Goes on where it stopped.\nTwice.\n"));
  EXPECT_THAT(run, HasSubstr("\ntoy run x.toml \\-o 'a b.h5'\ntoy run \\e \\-o x.h5\n.Ed\n"));
  EXPECT_THAT(run, HasSubstr(".Op Fl \"\\&\\-set\" Ar \"\\&KEY=VALUE\" No ...\n"));
  EXPECT_THAT(run, testing::Not(HasSubstr("secret")));
}

TEST(ManPages, TheProgramsOwn) {
  const std::string own = pages()[0].text;
  EXPECT_THAT(own, HasSubstr(".Nd does nothing\n"));
  EXPECT_THAT(own, HasSubstr(".Sh EXIT STATUS\n0 done; 1 a bug; 130 interrupted.\n"));
  EXPECT_THAT(own, HasSubstr(".It Cm \"\\&run\"\nRun a request.\n"));
  EXPECT_THAT(own, HasSubstr(".Xr toy-archive 1 ,\n.Xr toy-run 1 ,\n.Xr toy-wait 1\n"));
  EXPECT_THAT(own, testing::Not(HasSubstr("Not for people")));
}

}  // namespace
}  // namespace sleight::command_tree
