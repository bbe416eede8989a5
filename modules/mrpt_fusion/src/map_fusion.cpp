// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/maps/CEdgeVoxelMap.h>
#include <mrpt/maps/error_text.h>
#include <mrpt/maps/map_files.h>
#include <mrpt/slam/map_fusion.h>

#include <algorithm>

using namespace mrpt::slam;
using mrpt::maps::CEdgeVoxelMap;
using mrpt::maps::CProbOctoMap;
using mrpt::obs::CObservationLocalMap;
using mrpt::poses::CPose3DPDFGaussian;

namespace {

bool isEdges(const CObservationLocalMap& o) {
  return dynamic_cast<const CEdgeVoxelMap*>(o.map.get()) != nullptr;
}

/** Where a map is said to be, in the frame of another. */
CPose3DPDFGaussian priorOf(const CObservationLocalMap& map, const CObservationLocalMap& in) {
  const CPose3DPDFGaussian unknown = mrpt::fusion::noGuess();
  for (const auto& cov : {map.pose.cov, in.pose.cov})
    if (cov(0, 0) >= unknown.cov(0, 0)) return unknown;
  return map.pose - in.pose;
}

/** The growth of one map by others. */
class Growth {
 public:
  Growth(CProbabilisticMapMatching& matching, const std::vector<CObservationLocalMap::Ptr>& maps,
         const OnMember& on_member)
      : matching_(matching), maps_(maps), on_member_(on_member) {
    for (const auto& m : maps_) {
      ASSERTMSG_(m && m->map, "fuseMaps(): a robot's map is missing");
      FusionMember member;
      member.robot = m->sensorLabel;
      result_.members.push_back(member);
    }
    const auto first =
        std::find_if(maps_.begin(), maps_.end(), [](const auto& m) { return !isEdges(*m); });
    ASSERTMSG_(first != maps_.end(), "fuseMaps(): there is no map but edges");
    first_ = static_cast<size_t>(first - maps_.begin());
    mrpt::maps::withPath((*first)->sensorLabel, [&] {
      const auto map = mrpt::maps::asProbOctoMap(*(*first)->map);
      ASSERTMSG_(map, std::string("a ") + (*first)->map->GetRuntimeClass()->className +
                          " is not, and holds no, 3-D occupancy map");
      result_.map = *map;
    });
    result_.members[first_].joined = true;
  }

  FusionResult run(bool even_rejected) {
    while (const auto next = mostProbable(even_rejected)) join(*next);
    for (size_t i = 0; i < maps_.size(); i++)
      if (isEdges(*maps_[i])) match(i);
    return std::move(result_);
  }

 private:
  void match(size_t i) {
    FusionMember& member = result_.members[i];
    if (on_member_) {
      const auto joined = std::count_if(result_.members.begin(), result_.members.end(),
                                        [](const auto& m) { return m.joined; });
      on_member_(member.robot, static_cast<size_t>(joined));
    }
    mrpt::maps::withPath(member.robot, [&] {
      member.info = {};
      member.pose.copyFrom(*matching_.Align3DPDF(&result_.map, maps_[i]->map.get(),
                                                 priorOf(*maps_[i], *maps_[first_]), member.info));
    });
  }

  /** Of the matches that may join. */
  std::optional<size_t> mostProbable(bool even_rejected) {
    std::optional<size_t> best;
    for (size_t i = 0; i < maps_.size(); i++) {
      if (result_.members[i].joined || isEdges(*maps_[i])) continue;
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
    result_.map = matching_.merge(result_.map, *maps_[i]->map, member.pose.getMeanVal());
    member.joined = true;
  }

  CProbabilisticMapMatching& matching_;
  const std::vector<CObservationLocalMap::Ptr>& maps_;
  const OnMember& on_member_;
  size_t first_ = 0;
  FusionResult result_;
};

}  // namespace

bool FusionResult::isComplete() const {
  return std::all_of(members.begin(), members.end(),
                     [](const auto& m) { return m.joined || m.info.by_edges; });
}

FusionResult mrpt::slam::fuseMaps(CProbabilisticMapMatching& matching,
                                  const std::vector<CObservationLocalMap::Ptr>& maps,
                                  bool even_rejected, const OnMember& on_member) {
  return Growth(matching, maps, on_member).run(even_rejected);
}
