// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/core/exceptions.h>
#include <mrpt/fusion/many_maps.h>
#include <mrpt/fusion/poses.h>

#include <algorithm>
#include <optional>

#include "fusion_base/error_text.h"

namespace mrpt::fusion {
namespace {

/** Where a map is said to be, in the frame of another. */
mrpt::poses::CPose3DPDFGaussian priorOf(const RobotMap& map, const RobotMap& in) {
  auto unknown = noGuess();
  for (const auto& cov : {map.pose.cov, in.pose.cov})
    if (cov(0, 0) >= unknown.cov(0, 0)) return unknown;
  return map.pose - in.pose;
}

/** The growth of one map by others. */
class Growth {
 public:
  Growth(const std::vector<RobotMap>& maps, const Options& options, const OnMember& on_member,
         const OnIteration& on_iteration)
      : maps_(maps), options_(options), on_member_(on_member), on_iteration_(on_iteration) {
    for (const auto& m : maps_) result_.members.emplace_back().robot = m.robot;
    const auto first =
        std::find_if(maps_.begin(), maps_.end(), [](const auto& m) { return !m.map.edges; });
    ASSERTMSG_(first != maps_.end(), "fuseMaps(): there is no map but edges");
    first_ = static_cast<size_t>(first - maps_.begin());
    result_.members[first_].joined = true;
  }

  ManyFused run(bool even_rejected) {
    while (const auto next = mostProbable(even_rejected)) join(*next);
    for (size_t i = 0; i < maps_.size(); i++)
      if (maps_[i].map.edges) match(i);
    if (!result_.map) result_.map = std::make_unique<octomap::OcTree>(joinedMap());
    return std::move(result_);
  }

 private:
  const octomap::OcTree& joinedMap() const {
    return result_.map ? *result_.map : *maps_[first_].map.octree;
  }

  void match(size_t i) {
    FusionMember& member = result_.members[i];
    if (on_member_) {
      const auto joined = std::count_if(result_.members.begin(), result_.members.end(),
                                        [](const auto& m) { return m.joined; });
      on_member_(member.robot, static_cast<size_t>(joined));
    }
    withPath(member.robot, [&] {
      member.info = align({&joinedMap(), nullptr}, maps_[i].map, priorOf(maps_[i], maps_[first_]),
                          options_, on_iteration_);
    });
    member.pose = member.info.pose;
  }

  /** Of the matches that may join. */
  std::optional<size_t> mostProbable(bool even_rejected) {
    std::optional<size_t> best;
    for (size_t i = 0; i < maps_.size(); i++) {
      if (result_.members[i].joined || maps_[i].map.edges) continue;
      match(i);
      const auto& e = result_.members[i].info.evaluation;
      if ((e.accepted || even_rejected) &&
          (!best || e.probability > result_.members[*best].info.evaluation.probability))
        best = i;
    }
    return best;
  }

  void join(size_t i) {
    FusionMember& member = result_.members[i];
    result_.map =
        mergeMaps(joinedMap(), *maps_[i].map.octree, toEigen(member.pose.mean), options_.merge);
    member.joined = true;
  }

  const std::vector<RobotMap>& maps_;
  const Options& options_;
  const OnMember& on_member_;
  const OnIteration& on_iteration_;
  size_t first_ = 0;
  ManyFused result_;
};

}  // namespace

ManyFused fuseMaps(const std::vector<RobotMap>& maps, const Options& options, bool even_rejected,
                   const OnMember& on_member, const OnIteration& on_iteration) {
  return Growth(maps, options, on_member, on_iteration).run(even_rejected);
}

}  // namespace mrpt::fusion
