// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the exchange of robots of one name. */
#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "fusion_link/simulated_network.h"
#include "fusion_link/team_exchange.h"
#include "support/tree_tools.h"

using namespace map_tests;

namespace mrpt::fusion::test::name_exchange_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using Ids = std::vector<size_t>;

/** A time that tests set. */
struct Time {
  std::chrono::steady_clock::time_point now;
  TeamExchange::Clock clock() const {
    return [this] { return now; };
  }
};

/** Robots of one name. Each sends to the first robot of its list that is there. */
class Twins {
 public:
  /** A message, by its number in the order in which messages are sent. */
  using IsLost = std::function<bool(size_t)>;

  explicit Twins(IsLost is_lost) : is_lost_(std::move(is_lost)) {}

  /** A robot starts. \param[in] order Robots to which it sends. */
  void start(size_t id, Ids order) {
    robots_[id] = std::make_unique<Robot>(*this, std::move(order));
  }
  void leave(size_t id) { robots_.erase(id); }

  /** Lets the robots exchange messages for a time. A message takes no step, or one step. */
  void run(milliseconds time) {
    constexpr milliseconds kStep(100);
    for (const auto end = time_.now + time; time_.now < end; time_.now += kStep)
      for (auto& [id, robot] : robots_) {
        robot->exchange.step();
        if (robot->exchange.hasToLeave()) leaving_.insert(id);
      }
  }
  /** As run(), but robots that have to leave are gone 1 s later. */
  void runAndLeave(milliseconds time) {
    for (const auto end = time_.now + time; time_.now < end;) {
      const std::set<size_t> gone = leaving_;
      run(seconds(1));
      for (const size_t id : gone) leave(id);
    }
  }

  const TeamExchange& exchange(size_t id) const { return robots_.at(id)->exchange; }
  /** Returns the robots that are there. */
  Ids present() const {
    Ids ids;
    for (const auto& robot : robots_) ids.push_back(robot.first);
    return ids;
  }
  /** Returns the robots that had to leave at any time. */
  const std::set<size_t>& leaving() const { return leaving_; }
  size_t sent() const { return sent_; }

 private:
  struct Robot : public Link {
    Robot(Twins& all, Ids robots)
        : twins(all), order(std::move(robots)), exchange("a", *this, {}, {}, all.time_.clock()) {}

    Robot* target() const {
      for (const size_t id : order)
        if (const auto found = twins.robots_.find(id); found != twins.robots_.end())
          return found->second.get();
      return nullptr;
    }
    std::map<std::string, uint64_t> sessions() override {
      const Robot* to = target();
      return to ? std::map<std::string, uint64_t>{{"a", to->session}}
                : std::map<std::string, uint64_t>();
    }
    bool send(const std::string&, const std::string& message) override {
      Robot* to = target();
      if (to && !twins.is_lost_(twins.sent_++)) to->arrived.push_back(message);
      return to;
    }
    std::vector<std::string> receive(size_t) override { return std::exchange(arrived, {}); }
    void wait(milliseconds) override {}

    Twins& twins;
    Ids order;
    uint64_t session = ++twins.last_session_;
    std::vector<std::string> arrived;
    TeamExchange exchange;
  };

  IsLost is_lost_;
  Time time_;
  std::map<size_t, std::unique_ptr<Robot>> robots_;
  std::set<size_t> leaving_;
  size_t sent_ = 0;
  uint64_t last_session_ = 0;
};

bool none(size_t) { return false; }

TEST(NameExchange, TheLaterRobotLeavesWhicheverMessageIsLost) {
  for (const milliseconds lead : {milliseconds(0), milliseconds(300), milliseconds(200'000)})
    for (size_t lost = 0; lost < 40; lost++) {
      Twins twins([&](size_t message) { return message == lost; });
      twins.start(0, {1});
      twins.run(lead);
      twins.start(1, {0});
      twins.run(seconds(5));
      EXPECT_EQ(twins.leaving().size(), 1U) << lead.count() << " " << lost;
      EXPECT_TRUE(lead == seconds(0) || twins.leaving().count(1) == 1)
          << lead.count() << " " << lost;
      EXPECT_LT(twins.sent(), 40U);  // each message was lost in one of the runs
      twins.run(seconds(200));
      EXPECT_EQ(twins.leaving().size(), 1U) << lead.count() << " " << lost;
    }
}

TEST(NameExchange, TheLaterRobotLeavesAfterMessagesWereLostForLong) {
  for (size_t lost = 1; lost < 16; lost++) {
    Twins twins([&](size_t message) { return message < lost; });
    twins.start(0, {1});
    twins.run(seconds(2));
    twins.start(1, {0});
    twins.run(seconds(10));
    EXPECT_EQ(twins.leaving(), std::set<size_t>{1}) << lost;
  }
}

TEST(NameExchange, OneOfThreeStaysWhoeverHearsWhom) {
  const std::vector<std::vector<Ids>> topologies = {
      {{1, 2}, {2, 0}, {0, 1}}, {{2, 1}, {0, 2}, {1, 0}},  // circles
      {{1, 2}, {0, 2}, {0, 1}}, {{2, 1}, {2, 0}, {0, 1}},  // two of them hear each other
      {{2, 1}, {2, 0}, {1, 0}}, {{1, 2}, {0, 2}, {1, 0}}};
  const std::vector<Ids> orders = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                   {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  for (const auto& topology : topologies)
    for (const Ids& order : orders)
      for (size_t lost = 0; lost < 60; lost++) {
        Twins twins([&](size_t message) { return message == lost; });
        for (const size_t id : order) {
          twins.start(id, topology[id]);
          twins.run(milliseconds(200));
        }
        twins.runAndLeave(seconds(8));
        EXPECT_EQ(twins.present(), Ids{order[0]}) << lost;
        EXPECT_LT(twins.sent(), 60U);  // each message was lost in one of the runs
      }
}

TEST(NameExchange, RobotsThatDoNotLeaveSoonSayNothingMore) {
  for (const std::vector<Ids>& topology :
       {std::vector<Ids>{{1}, {2}, {0}}, {{1}, {0}, {0}}, {{2}, {2}, {0}}}) {
    Twins twins(none);
    for (size_t id = 0; id < 3; id++) twins.start(id, topology[id]);
    twins.run(seconds(65));
    EXPECT_LE(twins.sent(),
              3U * (60 + 2 * 60));  // each asks each second; each question is answered
    const size_t sent = twins.sent();
    twins.run(seconds(100));
    EXPECT_EQ(twins.sent(), sent);
  }
}

TEST(NameExchange, ARobotThatComesBackIsAskedAgain) {
  Twins twins(none);
  twins.start(0, {1});
  twins.run(seconds(100));
  for (int i = 0; i < 3; i++) {
    twins.start(1, {0});
    twins.runAndLeave(seconds(4));
    EXPECT_EQ(twins.present(), Ids{0});
  }
}

TEST(NameExchange, RobotsThatHaveRunForLongBothStay) {
  bool are_apart = true;
  Twins twins([&](size_t) { return are_apart; });
  twins.start(0, {1});
  twins.run(seconds(2));
  twins.start(1, {0});
  twins.run(seconds(9));
  EXPECT_TRUE(twins.exchange(1).mayLeave());
  twins.run(seconds(3));
  are_apart = false;
  twins.run(seconds(100));
  EXPECT_TRUE(twins.leaving().empty());
  EXPECT_TRUE(twins.exchange(0).hasTwin() && twins.exchange(1).hasTwin());
  EXPECT_FALSE(twins.exchange(0).mayLeave() || twins.exchange(1).mayLeave());
}

/** A robot on a network. */
struct Robot {
  Robot(SimulatedNetwork& network, const Time& time, const std::string& name)
      : port(network.connect(name)), exchange(name, *port, {}, {}, time.clock()) {}
  std::unique_ptr<SimulatedNetwork::Port> port;
  TeamExchange exchange;
};

TEST(NameExchange, OnlyRobotsOfTheNameAreTwinsAndEachKeepsItsOwnMap) {
  for (const bool older_looks_first : {true, false}) {
    SimulatedNetwork network(15, {0, 1000});
    Time time;
    Robot older(network, time, "a"), other(network, time, "b");
    const auto step = [&](const std::vector<Robot*>& robots) {
      for (Robot* robot : robots) robot->exchange.step();
      network.step();
      time.now += milliseconds(2);
    };
    for (int i = 0; i < 3; i++) step({&older, &other});
    EXPECT_FALSE(older.exchange.hasTwin());
    Robot newer(network, time, "a");
    auto map = std::make_shared<octomap::OcTree>(0.1);
    putVoxel(*map, {1, 2, 3}, 1.F);
    finish(*map);
    older.exchange.publish(map);
    newer.exchange.publish(std::make_shared<octomap::OcTree>(0.1));
    Robot& first = older_looks_first ? older : newer;
    Robot& second = older_looks_first ? newer : older;
    for (int i = 0; i < 10; i++) step({&first, &other, &second});
    EXPECT_TRUE(older.exchange.hasTwin() && newer.exchange.hasTwin());
    EXPECT_FALSE(other.exchange.hasTwin());
    EXPECT_FALSE(older.exchange.hasToLeave() || older.exchange.mayLeave());
    EXPECT_TRUE(newer.exchange.hasToLeave() && newer.exchange.mayLeave());
    EXPECT_FALSE(other.exchange.hasToLeave());
    EXPECT_TRUE(sameTree(*map, *joinBlocks(*older.exchange.maps().at({"a", ""}).blocks())));
    EXPECT_EQ(older.exchange.refused() + newer.exchange.refused(), 0U);
  }
}

TEST(NameExchange, OfManyRobotsOnABadNetworkOneStays) {
  SimulatedNetwork network(16, {0.6, 4});
  Time time;
  std::vector<std::unique_ptr<Robot>> robots;
  for (int i = 0; i < 4; i++) robots.push_back(std::make_unique<Robot>(network, time, "a"));
  for (int i = 0; i < 200 && robots.size() > 1; i++, time.now += milliseconds(100)) {
    for (auto robot = robots.begin(); robot != robots.end();) {
      (*robot)->exchange.step();
      robot = (*robot)->exchange.hasToLeave() ? robots.erase(robot) : std::next(robot);
    }
    network.step();
  }
  ASSERT_EQ(robots.size(), 1U);
  EXPECT_FALSE(robots[0]->exchange.hasToLeave());
}

}  // namespace
}  // namespace mrpt::fusion::test::name_exchange_test
