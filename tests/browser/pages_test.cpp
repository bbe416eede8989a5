// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the pages in a browser. */

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/run.h"
#include "support/browser.h"

using map_tests::Browser;
using Json = nlohmann::json;

namespace {

/** Returns the number of colours in the picture: a blank picture has few. */
constexpr const char* kColours = R"((() => {
  const gl = document.querySelector('#stage canvas');
  const flat = document.createElement('canvas');
  [flat.width, flat.height] = [gl.width, gl.height];
  const c = flat.getContext('2d');
  c.drawImage(gl, 0, 0);
  return new Set(new Uint32Array(c.getImageData(0, 0, gl.width, gl.height).data.buffer)).size;
})())";

/** Returns the picture, when all details are drawn. */
constexpr const char* kPicture = R"(new Promise((done) => {
  const canvas = document.querySelector('#stage canvas');
  const look = () => canvas.dataset.detail === 'fine' ? done(canvas.toDataURL()) : setTimeout(look, 20);
  look();
}))";

/** Returns all numbers on the page that have a path in the report: path, value, shown text. */
constexpr const char* kFigures = R"([...document.querySelectorAll('[data-path]')].map((e) => ({
  path: JSON.parse(e.dataset.path), value: e.dataset.value, text: e.textContent.replace(/,/g, ''),
  digits: +e.dataset.digits, scale: +e.dataset.scale})))";

class Page : public AppTest {
 protected:
  void SetUp() override {
    AppTest::SetUp();
    if (map_tests::chromium().empty())
      GTEST_SKIP() << "Chromium is not installed (Debian package chromium)";
  }
  Browser& browser() {
    if (!browser_) browser_ = std::make_unique<Browser>((dir_ / "browser").string());
    return *browser_;
  }
  /** Makes maps of few voxels, which are drawn soon without a graphics card. Returns both. */
  std::string coarse() const {
    for (const std::string map : {"map_a.ot", "map_b.ot"})
      EXPECT_EQ(mapFusion("transform " + pair(map) +
                          " --pose \"[0 0 0 0 0 0]\" --resolution 0.2 -q -o " + map)
                    .code,
                0);
    return "map_a.ot map_b.ot";
  }
  void open(const std::string& page) { browser().open((dir_ / page).string()); }
  void TearDown() override {
    if (browser_) {
      EXPECT_TRUE(browser_->errors.empty()) << browser_->errors.front();
      EXPECT_TRUE(browser_->requests.empty()) << browser_->requests.front();
    }
    browser_.reset();
    AppTest::TearDown();
  }

 private:
  std::unique_ptr<Browser> browser_;
};

/** Compares each number on the page with the report at its path. */
void expectNumbersOf(const Json& report, const Json& figures) {
  for (const Json& figure : figures) {
    const Json* at = &report;
    for (const Json& key : figure["path"])
      at = key.is_number() ? &at->at(key.get<size_t>()) : &at->at(key.get<std::string>());
    const double value = at->get<double>();
    EXPECT_EQ(std::stod(figure["value"].get<std::string>()), value) << figure;
    const double shown = std::stod(figure["text"].get<std::string>());
    EXPECT_NEAR(shown, value * figure["scale"].get<double>(),
                0.500001 * std::pow(10, -figure["digits"].get<int>()))
        << figure;
  }
}

TEST_F(Page, ShowsTheMapsAndTheNumbersOfTheJson) {
  const auto r = mapFusion("fuse " + both() + " --init " + guess(1, 10) +
                           " -o fused.ot --report page.html --json report.json -q");
  ASSERT_EQ(r.code, 0) << r.err;
  EXPECT_LT(fs::file_size(dir_ / "page.html"), 3'000'000U);
  open("page.html");
  browser().evaluate(kPicture);  // waits for all details
  EXPECT_GT(browser().evaluate(kColours), 40);
  const Json report = Json::parse(readFile(dir_ / "report.json"));
  EXPECT_EQ(
      Json::parse(
          browser().evaluate("document.getElementById('report').textContent").get<std::string>()),
      report);
  const Json figures = browser().evaluate(kFigures);
  EXPECT_GT(figures.size(), 40U);
  expectNumbersOf(report, figures);
  EXPECT_NE(browser().evaluate("document.querySelector('h1').textContent").dump().find("Accepted"),
            std::string::npos);
  RecordProperty("first_frame_ms",
                 browser().evaluate("document.documentElement.dataset.shown").dump());
}

TEST_F(Page, HasSwitchesThatChangeThePicture) {
  ASSERT_EQ(mapFusion("fuse " + coarse() + " --init " + guess(1, 10) +
                      " -o fused.ot --report page.html -q")
                .code,
            0);
  open("page.html");
  const Json layers =
      browser().evaluate("[...document.querySelectorAll('.layers input')].map((e) => e.id)");
  ASSERT_GE(layers.size(), 7U) << layers;
  for (const std::string layer : layers) {
    if (layer == "layer-ghost") continue;  // its pose may lie under the maps
    const auto before = browser().evaluate(kPicture);
    browser().click("#" + layer);
    const auto after = browser().evaluate(kPicture);
    EXPECT_NE(before, after) << layer;
  }
}

TEST_F(Page, IsTurnedByKeysAndCutByItsSliders) {
  ASSERT_EQ(
      mapFusion("match " + coarse() + " --init " + guess(1, 10) + " --report page.html -q").code,
      0);
  open("page.html");
  const auto changes = [&](const std::string& what, const auto& act) {
    const auto before = browser().evaluate(kPicture);
    act();
    EXPECT_NE(browser().evaluate(kPicture), before) << what;
  };
  browser().evaluate("document.querySelector('#stage canvas').focus()");
  for (const std::string key : {"ArrowLeft", "ArrowUp", "+", "t", "0"})
    changes(key, [&] { browser().press(key); });
  for (const std::string id : {"slider-probability", "slider-top", "slider-bottom"})
    changes(id, [&] {
      browser().evaluate(
          "(() => { const s = document.getElementById('" + id +
          "'); s.value = (+s.min + +s.max) / 2; s.dispatchEvent(new Event('input')); })()");
      browser().nextFrame();
    });
  changes("dark", [&] {
    browser().prefer("dark");
    browser().nextFrame();
  });
}

TEST_F(Page, ShowsAllAfterTheWindowHasChangedUntilTheUserMoves) {
  ASSERT_EQ(
      mapFusion("match " + coarse() + " --init " + guess(1, 10) + " --report page.html -q").code,
      0);
  open("page.html");
  browser().evaluate("document.querySelector('#stage canvas').focus()");
  const auto isReset = [&] {
    const auto before = browser().evaluate(kPicture);
    browser().press("0");
    return browser().evaluate(kPicture) == before;
  };
  for (const int width : {1100, 1700, 700}) {
    browser().resize(width, 800);
    EXPECT_TRUE(isReset()) << width;
  }
  browser().press("ArrowLeft");
  browser().resize(1500, 800);
  EXPECT_FALSE(isReset()) << "the user's view stays";
}

TEST_F(Page, StepsThroughTheRivals) {
  // At a wrong place, other poses agree nearly as well.
  ASSERT_EQ(mapFusion("match " + coarse() +
                      " --init \"[3 3 0 90 0 0]\" --init-sigma 0.2 2 --report "
                      "page.html -q")
                .code,
            3);
  open("page.html");
  const std::string text = "document.querySelector('.stepper .name').textContent";
  const auto before = browser().evaluate(text);
  browser().click(".stepper button:last-child");
  EXPECT_NE(browser().evaluate(text), before);
  EXPECT_EQ(browser().evaluate("document.getElementById('layer-ghost').checked"), true);
}

TEST_F(Page, ShowsNamesFromOutsideAsText) {
  const std::string name = "x<img src=y onerror=alert(1)>\x1b[31m\"'&lt;.ot";
  coarse();
  fs::copy(dir_ / "map_a.ot", dir_ / name);
  fs::copy(dir_ / "map_a.ot", dir_ / "c.ot");
  const auto r = run(MAP_FUSION " fuse x* map_b.ot c.ot -o o.ot --report page.html -q");
  ASSERT_TRUE(r.code == 0 || r.code == 3) << r.err;
  open("page.html");
  EXPECT_EQ(browser().evaluate("document.querySelectorAll('#panel img, #stage img').length"), 0);
  const std::string text = browser().evaluate("document.body.innerText");
  EXPECT_NE(text.find("x<img src=y onerror=alert(1)>\\u001b[31m\"'&lt;"), std::string::npos);
}

TEST_F(Page, ShowsAMap) {
  ASSERT_EQ(run("env -u DISPLAY -u WAYLAND_DISPLAY " MAP_FUSION " view " + pair("map_a.ot") +
                " -o map.html")
                .code,
            0);
  open("map.html");
  browser().evaluate(kPicture);  // waits for all details
  EXPECT_GT(browser().evaluate(kColours), 40);
}

}  // namespace
