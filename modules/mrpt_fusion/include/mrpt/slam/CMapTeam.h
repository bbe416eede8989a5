// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/export.h>
#include <mrpt/fusion/many_maps.h>
#include <mrpt/maps/CProbOctoMap.h>
#include <mrpt/obs/CObservationLocalMap.h>

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace mrpt::slam {

using TTeamLink = mrpt::fusion::TeamLink;  //!< A link to the robots of a team

/** The maps of a team of robots in a SLAM program, and the map that they make together.
 * \code
 * mrpt::slam::CMapTeam team;
 * team.setMap("r1", map1);                       // a snapshot: the program goes on with its map
 * team.setMap("r2", map2);
 * if (const auto r2 = team.member("r2"); r2 && r2->joined)
 *   std::cout << r2->pose << "\n";               // in the frame of r1, with covariance
 * team.fusedMap()->saveToOcTreeFile("fused.ot");
 * \endcode
 *
 * The robot that came first keeps its frame. The results are those of mrpt::fusion::fuseMaps() with
 * the present maps, bit for bit. A change costs what it touches, see mrpt::fusion::MapTeam. Several
 * threads may call all functions. A change does not wait for a fusion.
 *
 * A team with a link exchanges maps with the robots of a domain, as `map-fusion join` does:
 * \code
 * mrpt::slam::CMapTeam team(options, {"r1", 7});
 * team.setMap("r1", map1);                       // whenever it has changed: only changes are sent
 * const auto fused = team.fusedMap();            // null until there is a map
 * \endcode
 * The robots are in the order of their names. The results are those of the last fusion: no function
 * waits for one. Functions throw std::runtime_error if the link has failed, for example if another
 * robot has the name of this robot. */
class MRPT_FUSION_API CMapTeam {
 public:
  /** \param[in] options Parameters of all stages. */
  explicit CMapTeam(const mrpt::fusion::Options& options = {});
  /** Joins the robots of a domain. A thread exchanges and fuses until the destructor, which waits
   * up to 6 s for what is on its way. \param[in] options Parameters of all stages. \param[in] link
   * The robot and its link. Only one team of a process may have a link with the same domain.
   * \exception std::runtime_error If the link or the journal cannot be used, or if the library was
   * built without CycloneDDS. */
  CMapTeam(const mrpt::fusion::Options& options, const TTeamLink& link);
  ~CMapTeam();
  CMapTeam(const CMapTeam&) = delete;
  CMapTeam& operator=(const CMapTeam&) = delete;

  /** Adds the map of a robot, or replaces it. The map is copied and prepared once.
   * \param[in] robot Name of the robot.
   * \param[in] map The map, see mrpt::fusion::prepare().
   * \param[in] pose Guess of the pose of the map's frame in a common frame, if there is one.
   * \exception std::exception If the map is of another kind, or has no occupied voxel. With a link:
   * if the map is not that of this robot. */
  void setMap(const std::string& robot, const mrpt::maps::CMetricMap& map,
              const mrpt::poses::CPose3DPDFGaussian& pose = mrpt::fusion::noGuess());
  /** Adds the map that a robot has sent, or replaces its map. The map is not copied and must not
   * change afterwards. \return False if the team has had a map of this robot with a higher
   * sequence, or has removed this map: nothing changes. \exception std::exception As the other
   * function, and if the map is missing. */
  bool setMap(const mrpt::obs::CObservationLocalMap& sent);
  /** Removes the map of a robot. The map that the robot sent last, and earlier maps, are not added
   * if they arrive again. \return False if the team has no such robot. */
  bool removeMap(const std::string& robot);
  /** Returns the names of the robots, in the order in which they came. */
  std::vector<std::string> robots() const;

  /** Returns the result for a robot: pose with covariance, whether its map has joined, the verdict
   * with its reasons. Nothing if the team has no such robot. Fuses if something has changed.
   * \exception std::exception As mrpt::fusion::fuseMaps(). */
  std::optional<mrpt::fusion::FusionMember> member(const std::string& robot);
  /** Returns the results for all robots, in their order. Fuses if something has changed. */
  std::vector<mrpt::fusion::FusionMember> members() { return state()->members; }
  /** Returns the fused map, null if there is no map. Fuses if something has changed. The map does
   * not change afterwards; it has its sources. */
  std::shared_ptr<const mrpt::maps::CProbOctoMap> fusedMap();

 private:
  class Linked;

  std::shared_ptr<const mrpt::fusion::TeamState> state();
  void set(const std::string& robot, mrpt::fusion::PreparedMap map,
           const mrpt::poses::CPose3DPDFGaussian& pose);

  mrpt::fusion::FeatureParams features_;
  mrpt::fusion::MapTeam team_;
  std::unique_ptr<Linked> linked_;  //!< Null: without a link
  std::mutex sequences_mutex_;
  std::map<std::string, uint64_t> sequences_;  //!< Highest sequence of each robot's maps
  std::mutex fused_mutex_;
  std::shared_ptr<const mrpt::fusion::TeamState> fused_from_;
  std::shared_ptr<const mrpt::maps::CProbOctoMap> fused_;
};

}  // namespace mrpt::slam
