#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""draw_pages.py [--keep DIR]: draws the pictures of pages in doc/images anew.

Run scripts/demo.sh first: it leaves the first page, and the maps of the second, in build/demo. The other two pages
show robots in the simulated office. Needs Chromium (Debian package chromium) and python3-pil. Takes some minutes.
"""
import argparse
import base64
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parent))
sys.dont_write_bytecode = True
from benchmark_team import PROJECT, simulate  # noqa: E402

BUILD, IMAGES = PROJECT / "build", PROJECT / "doc/images"
WIDTH, HEIGHT, COLOURS = 1280, 800, 256
DRAWN = """new Promise((done) => {
  const canvas = document.querySelector('#stage canvas');
  const look = () => canvas.dataset.detail === 'fine' ? setTimeout(done, 500) : setTimeout(look, 50);
  look();
})"""


class Chromium:
    """Chromium without a window. It talks through two pipes: a JSON text and a zero byte each time."""

    def __init__(self, folder):
        from_us, self.to = os.pipe()
        self.answers, to_us = os.pipe()

        def connect():  # the browser reads 3 and writes 4
            ends = [os.dup2(end, high) for end, high in ((from_us, 100), (to_us, 101))]
            for end, low in zip(ends, (3, 4)):
                os.dup2(end, low)

        self.process = subprocess.Popen(
            ["chromium", "--headless", "--no-sandbox", "--remote-debugging-pipe", "--no-first-run", "--hide-scrollbars",
             "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist",
             f"--user-data-dir={folder}", "about:blank"],
            preexec_fn=connect, close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.session, self.number, self.rest = None, 0, b""
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]

    def call(self, method, **parameters):
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.to, json.dumps(message).encode() + b"\0")
        while True:
            while b"\0" not in self.rest:
                self.rest += os.read(self.answers, 1 << 20)
            answer, self.rest = self.rest.split(b"\0", 1)
            answer = json.loads(answer)
            if answer.get("id") == self.number:
                return answer["result"]

    def evaluate(self, script):
        return self.call("Runtime.evaluate", expression=script, awaitPromise=True)

    def draw(self, page, image, scheme, button=None):
        """Saves a picture of a page. button: text of a button that is pressed first."""
        self.call("Emulation.setDeviceMetricsOverride", width=WIDTH, height=HEIGHT, deviceScaleFactor=1, mobile=False)
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
        self.call("Page.navigate", url=f"file://{page.resolve()}")
        self.evaluate("new Promise((done) => { const wait = () => document.querySelector('#stage canvas') && "
                      "document.readyState === 'complete' ? done() : setTimeout(wait, 50); wait(); })")
        if button:
            self.evaluate(f"[...document.querySelectorAll('.buttons button')].find((b) => b.textContent === "
                          f"'{button}').click()")
        self.evaluate("new Promise((done) => setTimeout(done, 1000))")
        self.evaluate(DRAWN)
        shot = image.with_suffix(".new.png")
        shot.write_bytes(base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"]))
        Image.open(shot).convert("RGB").quantize(COLOURS).save(image, optimize=True)
        shot.unlink()

    def close(self):
        self.process.terminate()
        self.process.wait()


def report(folder, page, *arguments):
    """Runs map-fusion with --report. A rejected match is a result, too."""
    run = subprocess.run([BUILD / "bin/map-fusion", *arguments, "-q", "--report", folder / page], check=False)
    if run.returncode not in (0, 3):
        raise SystemExit(f"map-fusion {arguments[0]} failed")
    return folder / page


def maps_of_office(folder, seed):
    if not (folder / "mission.ini").exists():
        folder.mkdir(parents=True, exist_ok=True)
        simulate({"seed": seed, "robots": 8}, "office", BUILD, folder)
    return [folder / f"robot_{i}.ot" for i in range(8)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--keep", type=Path, help="folder of the maps and pages: kept, and used if they are there")
    options = parser.parse_args()
    demo = [BUILD / "demo/map_a.ot", BUILD / "demo/map_b.ot"]
    with tempfile.TemporaryDirectory() as scratch:
        folder = options.keep or Path(scratch) / "pages"
        robots, others = (maps_of_office(folder / str(seed), seed) for seed in (2, 3))
        pages = [
            ("page_demo", BUILD / "demo/page.html", "light"),
            ("page_rejected", report(folder, "rejected.html", "match", *demo, "--init", "[3 3 0 90 0 0]",
                                     "--init-sigma", "0.2", "2"), "dark", "Conflicts"),
            ("page_ambiguous", report(folder, "ambiguous.html", "match", others[0], others[3]), "light", "Rivals"),
            ("page_team", report(folder, "team.html", "fuse", *robots, "-o", folder / "fused.ot"), "dark")]
        browser = Chromium(Path(scratch) / "browser")
        try:
            for name, *how in pages:
                browser.draw(how[0], IMAGES / f"{name}.png", *how[1:])
        finally:
            browser.close()
    shutil.copy(BUILD / "demo/top_view.png", IMAGES / "top_view.png")


if __name__ == "__main__":
    main()
