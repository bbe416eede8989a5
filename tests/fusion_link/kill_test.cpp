// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Kills a robot at random moments. MRPT_FUSION_KILLS sets how often (default 15). */
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "fusion_link/simulated_network.h"
#include "fusion_link/team_exchange.h"
#include "support/file_tools.h"
#include "support/tree_tools.h"

using namespace map_tests;

namespace mrpt::fusion::test::kill_test {
namespace {

using Clock = std::chrono::steady_clock;
using Map = std::shared_ptr<const octomap::OcTree>;

/** A link to a robot in another process, by a socket. Each connection is a session. */
class SocketLink : public Link {
 public:
  explicit SocketLink(std::string other) : other_(std::move(other)) {}
  ~SocketLink() override { disconnect(); }
  SocketLink(const SocketLink&) = delete;
  SocketLink& operator=(const SocketLink&) = delete;

  void connect(int socket) {
    socket_ = socket;
    session_++;
  }
  void disconnect() {
    if (socket_ >= 0) ::close(socket_);
    socket_ = -1;
  }
  std::map<std::string, uint64_t> sessions() override {
    if (socket_ < 0) return {};
    return {{other_, session_}};
  }
  bool send(const std::string&, const std::string& message) override {
    return ::send(socket_, message.data(), message.size(), MSG_DONTWAIT | MSG_NOSIGNAL) > 0;
  }
  std::vector<std::string> receive(size_t most) override {
    std::vector<std::string> messages;
    std::string bytes(kMostMessageBytes, '\0');
    while (messages.size() < most) {
      const ssize_t n = ::recv(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT);
      if (n <= 0) break;
      messages.push_back(bytes.substr(0, static_cast<size_t>(n)));
    }
    return messages;
  }
  void wait(std::chrono::milliseconds most) override {
    pollfd arrived{socket_, POLLIN, 0};
    ::poll(&arrived, 1, static_cast<int>(most.count()));
  }

 private:
  std::string other_;
  int socket_ = -1;
  uint64_t session_ = 0;
};

/** Starts robot b, which collects until it is killed. */
pid_t startRobot(int socket, const std::string& journal) {
  const pid_t process = ::fork();
  if (process != 0) return process;
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  try {
    SocketLink link("a");
    link.connect(socket);
    TeamExchange b("b", link, journal);
    while (true) {
      b.step();
      link.wait(std::chrono::milliseconds(1));
    }
  } catch (...) {
    ::_exit(1);
  }
}

Map clutter(unsigned seed) {
  auto tree = std::make_shared<octomap::OcTree>(0.1);
  std::mt19937 random(seed);
  for (int i = 0; i < 15'000; i++)
    putVoxel(*tree,
             {static_cast<int>(random() % 120), static_cast<int>(random() % 30),
              static_cast<int>(random() % 20)},
             static_cast<float>(random() % 1000) / 300 - 1);
  finish(*tree);
  return tree;
}

TEST(TeamExchange, AKillLosesNothingThatWasAcknowledged) {
  const char* text = std::getenv("MRPT_FUSION_KILLS");
  const int kills = text ? std::atoi(text) : 15;
  const std::vector<Map> maps = {clutter(1), clutter(2), clutter(3)};
  const TempDir folder;
  const std::string journal = folder.path("b");
  std::map<uint64_t, MapIndex> indices;  // of the map of a, by version
  std::mt19937 random(4);
  SocketLink link("b");
  TeamExchange a("a", link);
  const auto publish = [&] {
    a.publish(maps[random() % maps.size()]);
    const MapIndex& index = *a.maps().at({"a", ""}).index();
    indices[index.version] = index;
  };
  publish();
  std::set<uint64_t> acknowledged;
  for (int kill = 0; kill < kills; kill++) {
    int sockets[2];
    ASSERT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET, 0, sockets), 0);
    const pid_t robot = startRobot(sockets[1], journal);
    ASSERT_GT(robot, 0);
    ::close(sockets[1]);
    link.connect(sockets[0]);
    const auto end = Clock::now() + std::chrono::milliseconds(random() % 500);
    while (Clock::now() < end) {
      a.step();
      link.wait(std::chrono::milliseconds(1));
      if (random() % 100 == 0) publish();
    }
    ::kill(robot, SIGKILL);
    int status = 0;
    ::waitpid(robot, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));
    a.step();  // what it had said before
    link.disconnect();
    a.step();

    SimulatedNetwork nobody(1, {});
    const auto port = nobody.connect("b");
    const TeamExchange b("b", *port, journal);
    const auto version = a.acknowledged().find("b");
    if (version == a.acknowledged().end() || version->second == 0) continue;
    acknowledged.insert(version->second);
    const MapReplica& held = b.maps().at({"a", ""});
    ASSERT_TRUE(held.index());
    EXPECT_GE(held.index()->version, version->second);
    for (const auto& [code, block] : indices.at(version->second).blocks)
      if (held.index()->blocks.count(code) > 0) {
        EXPECT_GE(held.versionOf(code), block) << "kill " << kill;
      }
  }
  EXPECT_GE(acknowledged.size(), static_cast<size_t>(kills / 5));
}

}  // namespace
}  // namespace mrpt::fusion::test::kill_test
