// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of --report and of `map-fusion view`. */

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "apps/run.h"

using Json = nlohmann::json;

namespace {

class PagesOfTheApp : public AppTest {
 protected:
  Json blockOf(const std::string& page, const std::string& id) const {
    const std::string text = readFile(dir_ / page);
    const std::string start = "<script type=\"application/json\" id=\"" + id + "\">";
    const size_t from = text.find(start);
    EXPECT_NE(from, std::string::npos) << page;
    if (from == std::string::npos) return {};
    const size_t begin = from + start.size();
    return Json::parse(text.substr(begin, text.find("</script>", begin) - begin));
  }
  /** Runs without a display, and with `bin` first in the path. */
  Result headless(const std::string& arguments) const {
    return run("env -u DISPLAY -u WAYLAND_DISPLAY " MAP_FUSION " " + arguments);
  }
  /** Makes a program xdg-open that notes its argument in `opened`. */
  void fakeOpener() const {
    fs::create_directory(dir_ / "bin");
    writeFile(dir_ / "bin/xdg-open",
              "#!/bin/sh\nprintf '%s' \"$1\" >'" + (dir_ / "opened.new").string() + "'\nmv '" +
                  (dir_ / "opened.new").string() + "' '" + (dir_ / "opened").string() + "'\n");
    fs::permissions(dir_ / "bin/xdg-open", fs::perms::owner_all);
  }
  /** Returns what the fake xdg-open was given. */
  std::string opened() const {
    run("for i in $(seq 200); do [ -e opened ] && break; sleep 0.05; done");
    return readFile(dir_ / "opened");
  }
};

TEST_F(PagesOfTheApp, AreWrittenByEachCommandOnTwoMaps) {
  const std::string pose = " --pose " + pair("T_a_b.txt"), g = " --init " + guess(0.5, 5);
  for (const std::string& command :
       {"fuse " + both() + g + " -o fused.ot", "match " + both() + g, "evaluate " + both() + pose,
        "merge " + both() + pose + " -o fused.ot"}) {
    const auto r = mapFusion(command + " --report page.html --json report.json -q");
    ASSERT_EQ(r.code, 0) << command << r.err;
    EXPECT_EQ(blockOf("page.html", "report"), Json::parse(readFile(dir_ / "report.json")));
    const Json scene = blockOf("page.html", "scene");
    EXPECT_EQ(scene["kind"], "pair");
    EXPECT_EQ(scene["maps"].size(), 2U);
    EXPECT_EQ(scene.contains("fused"), command.find("fused.ot") != std::string::npos) << command;
    EXPECT_EQ(scene["maps"][1]["conflicts"]["count"].get<double>() > 0, true);
    EXPECT_LT(fs::file_size(dir_ / "page.html"), 3'000'000U);
    fs::remove(dir_ / "page.html");
  }
}

TEST_F(PagesOfTheApp, ShowARejectedMatch) {
  const auto r =
      mapFusion("fuse " + both() +
                " --init \"[3 3 0 90 0 0]\" --init-sigma 0.2 2 -o fused.ot --report page.html");
  ASSERT_EQ(r.code, 3) << r.err;
  EXPECT_EQ(blockOf("page.html", "report")["match"]["accepted"], false);
  EXPECT_FALSE(blockOf("page.html", "scene").contains("fused"));
  EXPECT_FALSE(blockOf("page.html", "scene")["rivals"].empty());
}

TEST_F(PagesOfTheApp, ShowATeam) {
  ASSERT_EQ(
      mapFusion("transform " + pair("map_a.ot") + " --pose '[1 2 0 10 0 0]' -o again.ot").code, 0);
  const auto r =
      mapFusion("fuse " + both() + " again.ot -o fused.ot --report page.html --json r.json -q");
  ASSERT_TRUE(r.code == 0 || r.code == 3) << r.err;
  const Json report = blockOf("page.html", "report"), scene = blockOf("page.html", "scene");
  EXPECT_EQ(report, Json::parse(readFile(dir_ / "r.json")));
  EXPECT_EQ(report["pairs"].size(), 3U);
  EXPECT_EQ(scene["kind"], "team");
  EXPECT_EQ(scene["maps"].size(), 3U);
  EXPECT_EQ(scene["graph"]["links"].size(), 3U);
  EXPECT_LT(fs::file_size(dir_ / "page.html"), 8'000'000U);
}

TEST_F(PagesOfTheApp, FollowTheRulesOfOutputs) {
  const std::string merge = "merge " + both() + " --pose " + pair("T_a_b.txt") + " -o ";
  EXPECT_EQ(mapFusion(merge + "x.ot --report x.ot").code, 2);
  EXPECT_EQ(mapFusion(merge + "- --report -").code, 2);
  EXPECT_EQ(mapFusion(merge + "x.ot --report y --json y").code, 2);
  EXPECT_EQ(mapFusion(merge + "x.ot --report no/such/folder.html").code, 1);
  EXPECT_EQ(mapFusion("match " + both() + " --report a.ot").code, 2) << "no name of a page";
  fs::copy(pair("map_a.ot"), dir_ / "a.html");
  const auto r = mapFusion("match a.html " + pair("map_b.ot") + " --report a.html");
  EXPECT_EQ(r.code, 1);
  EXPECT_NE(r.err.find("is an input"), std::string::npos) << r.err;
  const auto piped = mapFusion(merge + "x.ot --report -");
  EXPECT_EQ(piped.code, 0) << piped.err;
  EXPECT_EQ(piped.out.substr(0, 15), "<!doctype html>");
  EXPECT_EQ(piped.out.substr(piped.out.size() - 8), "</html>\n");
  EXPECT_EQ(run("ls .x* *.tmp* 2>/dev/null").out, "");
}

TEST_F(PagesOfTheApp, ViewSaysWhereThePageIsWithoutADisplay) {
  const auto r = headless("view " + pair("map_a.ot") + " -o a.html");
  ASSERT_EQ(r.code, 0) << r.err;
  EXPECT_NE(r.out.find("open in a browser: " + (dir_ / "a.html").string()), std::string::npos)
      << r.out;
  EXPECT_EQ(blockOf("a.html", "report")["command"], "view");
  EXPECT_EQ(blockOf("a.html", "scene")["kind"], "maps");
  // A page is not written anew.
  const auto again = headless("view a.html");
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_NE(again.out.find("open in a browser: " + (dir_ / "a.html").string()), std::string::npos);
  EXPECT_EQ(headless("view a.html -o b.html").code, 1);
}

TEST_F(PagesOfTheApp, ViewWritesToANewFolderForTemporaryFiles) {
  fs::create_directory(dir_ / "tmp");
  const auto r = run("env -u DISPLAY -u WAYLAND_DISPLAY TMPDIR='" + (dir_ / "tmp").string() +
                     "' " MAP_FUSION " view -q " + pair("map_a.ot"));
  ASSERT_EQ(r.code, 0) << r.err;
  const auto found = run("find tmp -name map_a.html | wc -l");
  EXPECT_EQ(found.out, "1\n");
  EXPECT_EQ(run("find tmp -mindepth 1 -type d -perm 700 | wc -l").out, "1\n");
}

TEST_F(PagesOfTheApp, ViewOpensAPageWhereThereIsADisplay) {
  fakeOpener();
  ASSERT_EQ(headless("view -q " + pair("map_a.ot") + " -o \"it's; \\$(a) page.html\"").code, 0);
  const auto r =
      run("PATH=\"$PWD/bin:$PATH\" DISPLAY=:77 " MAP_FUSION " view \"it's; \\$(a) page.html\"");
  ASSERT_EQ(r.code, 0) << r.err;
  EXPECT_EQ(r.out.substr(0, 7), "opened ");
  EXPECT_EQ(opened(), (dir_ / "it's; $(a) page.html").string());
}

TEST_F(PagesOfTheApp, ViewRefusesOtherFiles) {
  writeFile(dir_ / "other.html", "<!doctype html>\n<html><body>not ours</body></html>\n");
  const auto r = headless("view other.html");
  EXPECT_EQ(r.code, 1);
  EXPECT_EQ(r.err.substr(0, 23), "map-fusion: other.html:") << r.err;
  EXPECT_EQ(headless("view missing.ot").code, 1);
  EXPECT_EQ(headless("view").code, 2);
}

}  // namespace
