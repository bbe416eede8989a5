// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the manual pages and of the completion of bash. */

#include <algorithm>
#include <vector>

#include "run.h"

namespace {

class Manuals : public AppTest {
 protected:
  /** Returns the names of options and commands that a text names: words of a pattern of grep. */
  std::vector<std::string> wordsIn(const std::string& command, const std::string& pattern) const {
    std::istringstream found(
        run(command + " | grep -oE -- '" + pattern + "' | tr -d ' ,' | sort -u").out);
    std::vector<std::string> words;
    for (std::string word; found >> word;) words.push_back(word);
    return words;
  }
  std::vector<std::string> commands() const {
    return wordsIn(std::string(MAP_FUSION) + " --help", "^  [a-z]+ ");
  }
  /** Returns the words that bash offers for a line whose last word is incomplete. */
  std::string completed(const std::string& line) const {
    const auto r = run("bash -c 'source " MANUALS "/map-fusion; COMP_WORDS=(" + line +
                       "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _map_fusion; "
                       "echo \"${COMPREPLY[*]}\"'");
    EXPECT_EQ(r.code, 0) << r.err;
    EXPECT_EQ(r.err, "");
    return r.out;
  }
};

TEST_F(Manuals, HaveAPageForEachCommandWithAllOptionsOfHelp) {
  ASSERT_GE(commands().size(), 10U);
  for (const std::string& command : commands()) {
    const std::string page = MANUALS "/man1/map-fusion-" + command + ".1";
    ASSERT_TRUE(fs::exists(page)) << page;
    const std::string option = "^ +(-[a-z], ?)?--[a-z0-9-]+";
    const auto in_help = wordsIn(std::string(MAP_FUSION) + " " + command + " --help", option);
    const auto in_page = wordsIn("MANWIDTH=200 man -E ascii -l " + page, option);
    EXPECT_GT(in_help.size(), 3U);
    EXPECT_EQ(in_help, in_page) << command;
  }
}

TEST_F(Manuals, AreFormattedWithoutWarnings) {
  for (const auto& page : fs::directory_iterator(MANUALS "/man1")) {
    const auto r = run("LC_ALL=C.UTF-8 MANWIDTH=80 man --warnings=w -E UTF-8 -l -Tutf8 -Z " +
                       page.path().string() + " > page.txt");
    EXPECT_EQ(r.code, 0) << page;
    EXPECT_EQ(r.err, "") << page;
    EXPECT_GT(fs::file_size(dir_ / "page.txt"), 1000U);
    const auto name = run("lexgrog " + page.path().string());
    EXPECT_EQ(name.code, 0) << name.out;
  }
}

TEST_F(Manuals, CompletionOffersCommandsOptionsAndWords) {
  EXPECT_EQ(completed("map-fusion me"), "merge\n");
  EXPECT_EQ(completed("map-fusion fuse --pol"), "--policy\n");
  EXPECT_EQ(completed("map-fusion merge --policy a"), "average\n");
  EXPECT_EQ(completed("map-fusion merge a"), "\n") << "bash completes files";
  EXPECT_EQ(completed("map-fusion info --pol"), "\n");
}

}  // namespace
