// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

/** \file
 * Headless Chromium for tests: opens a page, runs script in it, takes pictures, and hears its
 * errors and requests. It is driven through a pipe by the DevTools protocol, so that a test needs
 * no driver. */

namespace map_tests {

using BrowserJson = nlohmann::json;

/** Returns the program of Chromium; empty if it is not installed. */
inline std::string chromium() {
  for (const char* path :
       {"/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"})
    if (std::filesystem::exists(path)) return path;
  return {};
}

/** One page in a browser of its own. */
class Browser {
 public:
  /** \param[in] folder New folder for the files of the browser. */
  explicit Browser(const std::string& folder) {
    int to[2], from[2];
    if (::pipe2(to, O_CLOEXEC) || ::pipe2(from, O_CLOEXEC)) throw std::runtime_error("no pipe");
    posix_spawn_file_actions_t files;
    ::posix_spawn_file_actions_init(&files);
    // High numbers first: 3 and 4 may be ends of the pipes themselves.
    const int in = ::fcntl(to[0], F_DUPFD_CLOEXEC, 100),
              out = ::fcntl(from[1], F_DUPFD_CLOEXEC, 100);
    ::posix_spawn_file_actions_adddup2(&files, in, 3);
    ::posix_spawn_file_actions_adddup2(&files, out, 4);
    for (const int output : {1, 2})
      ::posix_spawn_file_actions_addopen(&files, output, "/dev/null", O_WRONLY, 0);
    std::vector<std::string> words = {
        chromium(), "--headless", "--no-sandbox", "--remote-debugging-pipe", "--no-first-run",
        "--disable-background-networking", "--disable-component-update", "--disable-sync",
        "--disable-quic", "--disable-dev-shm-usage", "--window-size=1000,640",
        // Draws in software, as on a machine without a graphics card.
        "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist",
        "--user-data-dir=" + folder, "about:blank"};
    std::vector<char*> arguments;
    for (auto& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawnattr_t attributes;
    ::posix_spawnattr_init(&attributes);
    ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    const int failed =
        ::posix_spawn(&process_, words[0].c_str(), &files, &attributes, arguments.data(), environ);
    ::posix_spawnattr_destroy(&attributes);
    ::posix_spawn_file_actions_destroy(&files);
    for (const int end : {to[0], from[1], in, out}) ::close(end);
    to_ = to[1];
    from_ = from[0];
    if (failed) throw std::runtime_error("Chromium does not start");
    const auto target = call("Target.createTarget", {{"url", "about:blank"}})["targetId"];
    session_ =
        call("Target.attachToTarget", {{"targetId", target}, {"flatten", true}})["sessionId"];
    for (const char* domain : {"Page", "Runtime", "Log", "Network"})
      call(std::string(domain) + ".enable", BrowserJson::object());
  }
  ~Browser() {
    ::close(to_);
    ::close(from_);
    ::kill(-process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  std::vector<std::string> errors;    ///< Messages of the console, and exceptions
  std::vector<std::string> requests;  ///< Addresses that were asked for, but that of the page

  /** Opens a file, and waits until it is loaded and drawn. */
  void open(const std::string& file) {
    const std::string address = "file://" + std::filesystem::absolute(file).string();
    page_ = address;
    call("Page.navigate", {{"url", address}});
    await([&] { return is_loaded_; });
    evaluate("new Promise(r => requestAnimationFrame(() => requestAnimationFrame(() => r(1))))");
  }
  /** Prefers "dark" or "light" colours. */
  void prefer(const std::string& scheme) {
    call("Emulation.setEmulatedMedia",
         {{"features", {{{"name", "prefers-color-scheme"}, {"value", scheme}}}}});
  }
  /** Runs script, and returns its value. */
  BrowserJson evaluate(const std::string& script) {
    const auto result =
        call("Runtime.evaluate",
             {{"expression", script}, {"returnByValue", true}, {"awaitPromise", true}});
    if (result.contains("exceptionDetails"))
      throw std::runtime_error("script failed: " + result["exceptionDetails"].dump());
    return result["result"].value("value", BrowserJson());
  }
  /** Clicks an element as a user does, and waits for the next frame. */
  void click(const std::string& selector) {
    const auto at =
        evaluate("(() => { const r = document.querySelector('" + selector +
                 "').getBoundingClientRect(); return [r.x + r.width / 2, r.y + r.height / "
                 "2]; })()");
    for (const char* type : {"mousePressed", "mouseReleased"})
      call("Input.dispatchMouseEvent",
           {{"type", type}, {"x", at[0]}, {"y", at[1]}, {"button", "left"}, {"clickCount", 1}});
    nextFrame();
  }
  /** Presses a key, for example "ArrowLeft". */
  void press(const std::string& key) {
    for (const char* type : {"keyDown", "keyUp"})
      call("Input.dispatchKeyEvent", {{"type", type}, {"key", key}, {"code", key}});
    nextFrame();
  }
  /** Changes the size of the window, pixels. */
  void resize(int width, int height) {
    call("Emulation.setDeviceMetricsOverride",
         {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", false}});
    nextFrame();
  }
  void nextFrame() {
    evaluate("new Promise(r => requestAnimationFrame(() => requestAnimationFrame(() => r(1))))");
  }
  /** Returns a picture of the page: a PNG file in base64. */
  std::string screenshot() { return call("Page.captureScreenshot", {{"format", "png"}})["data"]; }

 private:
  static constexpr int kPatience = 120;  // s

  BrowserJson call(const std::string& method, const BrowserJson& parameters) {
    BrowserJson message = {{"id", ++calls_}, {"method", method}, {"params", parameters}};
    if (!session_.empty()) message["sessionId"] = session_;
    const std::string text = message.dump() + '\0';
    for (size_t sent = 0; sent < text.size();) {
      const ssize_t n = ::write(to_, text.data() + sent, text.size() - sent);
      if (n <= 0) throw std::runtime_error("Chromium is gone");
      sent += static_cast<size_t>(n);
    }
    BrowserJson answer;
    awaited_ = &answer;
    await([&] { return !answer.is_null(); });
    awaited_ = nullptr;
    if (answer.contains("error")) throw std::runtime_error(method + ": " + answer["error"].dump());
    return answer["result"];
  }
  /** Reads messages until something has happened. */
  void await(const std::function<bool()>& has_happened) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(kPatience);
    while (!has_happened()) {
      if (const size_t at = received_.find('\0'); at != std::string::npos) {
        const auto message = BrowserJson::parse(received_.substr(0, at));
        received_.erase(0, at + 1);
        hear(message);
        continue;
      }
      pollfd file{from_, POLLIN, 0};
      char bytes[1 << 16];
      if (std::chrono::steady_clock::now() > end)
        throw std::runtime_error("Chromium does not answer");
      if (::poll(&file, 1, 1000) <= 0) continue;
      const ssize_t n = ::read(from_, bytes, sizeof(bytes));
      if (n <= 0) throw std::runtime_error("Chromium is gone");
      received_.append(bytes, static_cast<size_t>(n));
    }
  }
  void hear(const BrowserJson& message) {
    if (message.value("id", -1) == calls_ && awaited_) *awaited_ = message;
    const std::string method = message.value("method", "");
    if (method == "Page.loadEventFired") is_loaded_ = true;
    if (method == "Runtime.consoleAPICalled" || method == "Runtime.exceptionThrown" ||
        method == "Log.entryAdded")
      errors.push_back(message["params"].dump());
    if (method == "Network.requestWillBeSent") {
      const std::string address = message["params"]["request"]["url"];
      if (address != page_ && address.substr(0, 5) != "data:") requests.push_back(address);
    }
  }

  pid_t process_ = 0;
  int to_ = -1, from_ = -1, calls_ = 0;
  std::string session_, received_, page_;
  BrowserJson* awaited_ = nullptr;
  bool is_loaded_ = false;
};

}  // namespace map_tests
