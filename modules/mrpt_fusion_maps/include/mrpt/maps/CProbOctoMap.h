// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/config/CLoadableOptions.h>
#include <mrpt/fusion/compat.h>
#include <mrpt/fusion/export.h>
#include <mrpt/fusion/sources.h>
#include <mrpt/maps/CMetricMap.h>
#include <mrpt/maps/COctoMap.h>
#include <mrpt/poses/CPose3D.h>
#include <octomap/OcTree.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace mrpt::fusion {

class MapPublisher;
class MapReplica;
struct SourcesOfMap;

/** A link to the robots of a team, see doc/joining.md. */
struct TeamLink {
  std::string robot;               //!< Name of this robot
  uint32_t domain = 0;             //!< Number of the domain, 0 to 232: robots of one domain meet
  std::vector<std::string> peers;  //!< Addresses of robots; empty: robots are found by multicast
  std::string journal;             //!< Folder that keeps what has arrived; empty: none
};

}  // namespace mrpt::fusion

namespace mrpt::obs {
class CObservationMapDiff;
}

namespace mrpt::maps {

class CColouredOctoMap;
class COccupancyGridMap3D;

/** A 3-D probabilistic occupancy map: an octomap::OcTree as an MRPT metric map. Saving, sending and
 * copying keep every log-odds value.
 *
 * The map takes the observations, options and .ini keys of mrpt::maps::COctoMap. The differences
 * are:
 *  - Serialization keeps the log-odds of every node bit for bit, the structure of the tree and the
 * sensor model. COctoMap keeps one bit per voxel, and changes the map that it saves.
 *  - The `sensorPose` of a 3-D observation moves its points and the origin of the rays. COctoMap
 * moves the origin only.
 *  - A 3-D range scan with only a range image is projected to points.
 *  - isEmpty() is true for a fresh map.
 *  - The occupied voxels are points for ICP and other algorithms, see getAsSimplePointsMap().
 *  - octree() returns the octree.
 *  - Inserting the mrpt::obs::CObservationMapDiff of a robot makes this map the map of that robot,
 * bit for bit. The map must be empty, or come from diffs of the same robot. While blocks are
 * missing that earlier diffs had, nothing is inserted.
 *
 * The name in .ini map definitions is `probOctoMap`. An unknown key or a value out of range is an
 * exception that names section and key:
 * \code
 * [MappingApplication]
 * probOctoMap_count = 1
 * [MappingApplication_probOctoMap_00_creationOpts]
 * resolution = 0.10      // voxel size, m
 * [MappingApplication_probOctoMap_00_insertOpts]
 * maxrange = -1          // m, -1: whole beams
 * pruning = true
 * occupancyThres = 0.5   // this value and the following values are probabilities
 * probHit = 0.7
 * probMiss = 0.4
 * clampingThresMin = 0.1192
 * clampingThresMax = 0.971
 * [MappingApplication_probOctoMap_00_likelihoodOpts]
 * decimation = 1         // every decimation-th ray is used
 * [MappingApplication_probOctoMap_00_linkOpts]
 * robot = r1             // default: the map is not sent
 * domain = 7             // 0 to 232
 * peers =                // addresses of other robots; default: they are found by multicast
 * journal =              // folder; default: none
 * \endcode
 * With a robot, the map is sent to the robots of the domain while observations and points are
 * inserted, see doc/joining.md. Another thread sends it: insertion neither waits nor throws. Once a
 * second at most, the map is copied. The destructor sends the last state, for at most 6 s. Copies
 * of the map are not sent. A program sends one map to a domain: the first that is inserted into.
 */
class MRPT_FUSION_API CProbOctoMap : public CMetricMap {
  DEFINE_SERIALIZABLE(CProbOctoMap, mrpt::maps)

 public:
  /** Creates an empty map. \param[in] resolution Voxel size, m. \exception std::exception If the
   * resolution is not positive. */
  explicit CProbOctoMap(double resolution = 0.10);
  /** Takes over a tree with its sensor model. */
  explicit CProbOctoMap(std::unique_ptr<octomap::OcTree> tree);
  /** Copies a tree with its sensor model. */
  explicit CProbOctoMap(const octomap::OcTree& tree);
  /** Creates a map with the same leaves as \a o, see fromOctoMap(). */
  explicit CProbOctoMap(const COctoMap& o);
  /** \overload */
  explicit CProbOctoMap(const CColouredOctoMap& o);
  /** Creates a map of the cells of \a o, see fromOccupancyGrid(). */
  explicit CProbOctoMap(const COccupancyGridMap3D& o);
  /** Copies the map with its tree. O(nodes). */
  CProbOctoMap(const CProbOctoMap& o);
  /** Copies the map with its tree. O(nodes). */
  CProbOctoMap& operator=(const CProbOctoMap& o);
  /** Moves the map. The other map has no tree then: it can only be destroyed or assigned to. */
  CProbOctoMap(CProbOctoMap&&) = default;
  /** Moves the map. The other map has no tree then: it can only be destroyed or assigned to. */
  CProbOctoMap& operator=(CProbOctoMap&&) = default;
  ~CProbOctoMap() override;

  /** Options of insertions. Names, meaning and defaults are those of COctoMap::TInsertionOptions.
   * Probabilities are in (0,1). Each insertion sets the sensor model of the octree to them. */
  struct TInsertionOptions : public mrpt::config::CLoadableOptions {
    double maxrange = -1;              //!< Length to which beams are inserted, m; -1: whole beams
    bool pruning = true;               //!< Whether each insertion prunes the tree, without loss
    double occupancyThres = 0.5;       //!< Probability from which a voxel is occupied
    double probHit = 0.7;              //!< Probability that a voxel with a hit is occupied
    double probMiss = 0.4;             //!< Probability that a voxel crossed by a beam is occupied
    double clampingThresMin = 0.1192;  //!< Lowest probability that a voxel can reach
    double clampingThresMax = 0.971;   //!< Highest probability that a voxel can reach

    /** Loads the options. Options without a key keep their values. \exception std::exception With
     * section and key, if there is an unknown key or a value that check() rejects. Nothing is
     * changed then. */
    void loadFromConfigFile(const mrpt::config::CConfigFileBase& source,
                            const std::string& section) override;
    /** Saves all options, each with a comment. */
    void saveToConfigFile(mrpt::config::CConfigFileBase& target,
                          const std::string& section) const override;
    /** Checks the options. \exception std::exception With the name of the option, if a probability
     * is not in (0,1), if probHit < 0.5 or probMiss > 0.5, if clampingThresMin is not below
     * clampingThresMax, or if maxrange is neither -1 nor positive. */
    void check() const;
  };
  using TLikelihoodOptions = COctoMap::TLikelihoodOptions;  //!< Those of COctoMap
  using TRenderingOptions = COctoMap::TRenderingOptions;    //!< Those of COctoMap

  TInsertionOptions insertionOptions;    //!< Options of insertObservation() and insertPointCloud()
  TLikelihoodOptions likelihoodOptions;  //!< Options of computeObservationLikelihood()
  TRenderingOptions renderingOptions;    //!< Options of getAsOctoMapVoxels()

  MAP_DEFINITION_START(CProbOctoMap)
  double resolution = 0.10;                                     //!< Voxel size, m
  mrpt::maps::CProbOctoMap::TInsertionOptions insertionOpts;    //!< Becomes insertionOptions
  mrpt::maps::CProbOctoMap::TLikelihoodOptions likelihoodOpts;  //!< Becomes likelihoodOptions
  mrpt::fusion::TeamLink linkOpts;  //!< To whom the map is sent; without a robot: to nobody
  MAP_DEFINITION_END(CProbOctoMap)

  /** @name The octree
   * @{ */
  /** Returns the tree. The map owns it. */
  const octomap::OcTree& octree() const { return *m_octree; }
  /** \overload
   * After this call, each insertion of an observation visits all nodes of the tree, because the
   * caller may have changed any node. To read the tree only, call std::as_const(map).octree(). */
  octomap::OcTree& octree() {
    m_tree_state.lend();
    return *m_octree;
  }
  /** Takes over a tree. The sensor model of the tree becomes that of insertionOptions. */
  void setOctree(std::unique_ptr<octomap::OcTree> tree);

  /** Returns the sources of a fused map: which maps of which robots are in it. Empty: the map is
   * not known to be fused. If the voxels have changed since setSources(), the map itself is one
   * more source. Copies, streams and missions carry the sources; octree files do not. Cost: one
   * traversal, nothing without sources. */
  mrpt::fusion::Sources sources() const;
  /** Sets the sources of the present voxels. Names are cut after 1000 bytes.
   * \exception std::length_error If there are more than 100000 sources. */
  void setSources(mrpt::fusion::Sources sources);

  /** Returns the voxel size, m. */
  double getResolution() const { return m_octree->getResolution(); }
  /** Returns the number of nodes, with inner nodes. */
  size_t size() const { return m_octree->size(); }
  /** Returns the number of leaves. A pruned leaf counts once. */
  size_t getNumLeafNodes() const { return m_octree->getNumLeafNodes(); }
  size_t memoryUsage() const { return m_octree->memoryUsage(); }  //!< Size of the tree, bytes
  /** Returns the lowest corner of the box of the known space, m. */
  void getMetricMin(double& x, double& y, double& z) const { m_octree->getMetricMin(x, y, z); }
  /** Returns the highest corner of the box of the known space, m. */
  void getMetricMax(double& x, double& y, double& z) const { m_octree->getMetricMax(x, y, z); }
  /** Returns the occupancy probability at a point of the map's frame, m.
   * \return False if the point is unknown. \a prob_occupancy is not changed then. */
  bool getPointOccupancy(float x, float y, float z, double& prob_occupancy) const;
  /** Counts one hit or one miss in the voxel at a point, m. */
  void updateVoxel(double x, double y, double z, bool occupied);
  /** Inserts points of the map's frame, seen from a sensor at (sensor_x, sensor_y, sensor_z), m. */
  void insertPointCloud(const CPointsMap& points, float sensor_x, float sensor_y, float sensor_z);
  /** Inserts points of the map's frame without the position of the sensor. Each point is one hit in
   * its voxel. No space becomes free. */
  void insertPointCloud(const CPointsMap& points);
  /** Finds the first occupied voxel along a ray, see COctoMapBase::castRay(). */
  bool castRay(const mrpt::math::TPoint3D& origin, const mrpt::math::TPoint3D& direction,
               mrpt::math::TPoint3D& end, bool ignoreUnknownCells = false,
               double maxRange = -1.0) const;
  /** @} */

  /** @name Conversion
   * @{ */
  /** Replaces this map by a copy of \a o: the cubes of the leaves, their log-odds, the resolution,
   * the sensor model and the options. Colours are not copied. MRPT returns probabilities as
   * doubles, so log-odds are exact for 1e-7 < |log-odds| < 20, and rounded outside of that range.
   * \a o is not modified. \exception std::exception If the voxels of \a o do not lie on the grid of
   * an octree. */
  void fromOctoMap(const COctoMap& o);
  void fromOctoMap(const CColouredOctoMap& o);  //!< \overload
  /** Replaces the contents of \a o by this map: the same log-odds of the leaves, sensor model and
   * options. Cost: one descent from the root per finest voxel, because MRPT has no other way to
   * write voxels. Pruned leaves are expanded. \exception std::exception If |log-odds| > 36: such a
   * value has no probability in double precision. */
  void toOctoMap(COctoMap& o) const;
  /** A map with colours. */
  struct ColourSource {
    const CColouredOctoMap& map;  //!< The map. Not owned
    mrpt::poses::CPose3D pose;    //!< Its pose in the frame of the coloured result
  };
  /** Returns this map, see toOctoMap(), with the colours of other maps. So the colours of two maps
   * survive their fusion.
   *
   * An occupied leaf gets the mean of the colours that the sources have at its voxels. The colour
   * of a source at a voxel is the colour of its occupied voxel at the same place. If there is none,
   * it is the colour of its nearest occupied voxel within half a voxel diagonal (of the larger
   * voxel), because rotated grids do not coincide. A leaf without a colour is white, as in octomap.
   *
   * The result is a pointer, because octomap copies the occupancy of a CColouredOctoMap only.
   * MRPT's serialization loses the colours and the probabilities. The 3-D scene that
   * saveMetricMapRepresentationToFile() writes has the colours. */
  std::shared_ptr<CColouredOctoMap> toColouredOctoMap(
      const std::vector<ColourSource>& sources = {}) const;

  /** Replaces the octree by the known cells of a grid. The options and the sensor model stay. The
   * log-odds are those of the grid, multiples of 1/16. Cells with p = 0.5 are unknown. The extent
   * of the grid is lost. If its cells do not lie on the grid of an octree, each cell moves to the
   * voxel that covers most of it, by at most half a voxel. \exception std::exception If the cells
   * are not cubes, or if they are outside of the grid of an octree (2^15 voxels from the origin).
   */
  void fromOccupancyGrid(const COccupancyGridMap3D& o);
  /** Replaces the cells of \a o by the box of the known space of this map. Unknown voxels have
   * p = 0.5. An empty map becomes one unknown cell. Log-odds are rounded to multiples of 1/16, so
   * voxels within 1/32 of 0 become unknown, and clamped to +-127/16 (to +-32767/16 if MRPT has
   * 16-bit cells). The sensor model is lost. \exception std::exception If the box has more than
   * 10^8 voxels.
   */
  void toOccupancyGrid(COccupancyGridMap3D& o) const;
  /** @} */

  /** @name Points and matching
   * The points of the map are the centres of its occupied voxels in the order of the octree. Pruned
   * leaves are expanded. Indices in correspondences refer to this order. The other map may be a map
   * of points, a map that asProbOctoMap() takes, or a set of these. The functions throw for all
   * other maps. Several threads may call the functions at the same time. Cost: each matching makes
   * the points and the k-d tree of MRPT.
   * @{ */
  /** Returns the points. Each call makes them anew. If the map has not changed, the result is the
   * same object as before. It is valid until the first call after a change of the map, or until
   * auxParticleFilterCleanUp(). Never null. \exception std::length_error If there are more than
   * 10^8 points. */
  const CSimplePointsMap* getAsSimplePointsMap() const override;
  /** Frees the points that getAsSimplePointsMap() has returned. */
  void auxParticleFilterCleanUp() override;
  /** Matches the points of both maps as CPointsMap does. */
  void determineMatching2D(const CMetricMap* otherMap, const mrpt::poses::CPose2D& otherMapPose,
                           mrpt::tfest::TMatchingPairList& correspondences,
                           const TMatchingParams& params,
                           TMatchingExtraResults& extraResults) const override;
  /** Matches the points of both maps as CPointsMap does. */
  void determineMatching3D(const CMetricMap* otherMap, const mrpt::poses::CPose3D& otherMapPose,
                           mrpt::tfest::TMatchingPairList& correspondences,
                           const TMatchingParams& params,
                           TMatchingExtraResults& extraResults) const override;
  /** Returns the share of the points of the other map that have a point of this map within
   * `params.maxDistForCorr`, m, as CPointsMap does. */
  float compute3DMatchingRatio(const CMetricMap* otherMap, const mrpt::poses::CPose3D& otherMapPose,
                               const TMatchingRatioParams& params) const override;
  /** Returns the square distance in the plane to the closest point, m^2. Cost: one descent of the
   * octree. No points are made. \exception std::exception If there is no occupied voxel. */
  float squareDistanceToClosestCorrespondence(float x0, float y0) const override;
  /** @} */

  /** @name Files
   * @{ */
  /** Loads a `.ot` or `.bt` file. The content decides which it is. insertionOptions get the sensor
   * model of the tree. \exception std::runtime_error "<path>: <reason>". */
  void loadFromOcTreeFile(const std::string& path);
  /** Saves all log-odds (`.ot`) or the maximum likelihood (`.bt`), depending on the extension.
   * Writes the whole file or nothing. \exception std::runtime_error "<path>: <reason>". */
  void saveToOcTreeFile(const std::string& path) const;
  /** Loads the contents of a `.ot` or `.bt` file, see loadFromOcTreeFile().
   * \param[in] bytes The contents.
   * \param[in] resolution Voxel size of nodes without a header, as the data of
   * octomap_msgs/Octomap, m. 0: \a bytes has a header.
   * \exception std::runtime_error If the bytes are damaged or of another kind. */
  void loadFromOcTreeBytes(std::string_view bytes, double resolution = 0);
  /** Returns the contents of a `.ot` file: all log-odds. */
  std::string toOtBytes() const;
  /** Returns the contents of a `.bt` file: the maximum likelihood. */
  std::string toBtBytes() const;
  /** Writes `<prefix>_3D.3Dscene`, as the maps of MRPT do, and `<prefix>.ot` with all log-odds. */
  void saveMetricMapRepresentationToFile(const std::string& filNamePrefix) const override;
  /** @} */

  /** Returns whether no voxel is known. */
  bool isEmpty() const override { return m_octree->size() == 0; }
  std::string asString() const override;  //!< Resolution and size in one line
  /** Adds the voxels, see getAsOctoMapVoxels(), if genericMapParams.enableSaveAs3DObject is set. */
  void getVisualizationInto(mrpt::fusion::viz::CSetOfObjects& o) const override;
  /** Fills a voxel object of MRPT as COctoMap does: same voxel sets, colours and renderingOptions.
   */
  void getAsOctoMapVoxels(mrpt::fusion::viz::COctoMapVoxels& gl_obj) const;

 protected:
  /** @name Interface of CMetricMap
   * @{ */
  void internal_clear() override;  //!< Clears the tree. Keeps resolution and options
  /** Inserts the points of a 2-D or 3-D scan. \return False if observations of this kind have no
   * points. */
  bool internal_insertObservation(
      const mrpt::obs::CObservation& obs,
      const std::optional<const mrpt::poses::CPose3D>& robotPose = std::nullopt) override;
  /** Returns the sum of the logarithms of the probabilities at the points of the observation. */
  double internal_computeObservationLikelihood(
      const mrpt::obs::CObservation& obs, const mrpt::poses::CPose3D& takenFrom) const override;
  /** Returns true for observations that can be inserted. */
  bool internal_canComputeObservationLikelihood(const mrpt::obs::CObservation& obs) const override;
  /** @} */

 private:
  void applySensorModel();
  /** Replaces the tree, of which nothing is known. */
  void replaceTree(std::unique_ptr<octomap::OcTree> tree);

  /** What is known about the inner nodes of the tree, see InnerNodes in fusion_octree. Several
   * threads may call octree() at the same time. */
  class TreeState {
   public:
    explicit TreeState(uint8_t inner_nodes) : m_value(inner_nodes) {}
    TreeState(const TreeState& o) : m_value(o.m_value.load()) {}
    TreeState& operator=(const TreeState& o) {
      m_value = o.m_value.load();
      return *this;
    }
    void lend() { m_value = kLent; }  //!< The caller of octree() may change any node at any time
    uint8_t innerNodes() const { return m_value == kLent ? uint8_t{0} : m_value.load(); }
    void setInnerNodes(uint8_t known) {
      if (m_value != kLent) m_value = known;
    }

   private:
    static constexpr uint8_t kLent = 255;
    std::atomic<uint8_t> m_value;
  };
  bool insert(const mrpt::obs::CObservation& obs, const mrpt::poses::CPose3D& robot);
  /** Sends the map, if it is sent. */
  void publish() noexcept;
  /** Makes this map the map that the diffs of a robot give. \return False if the map is not from
   * diffs of this robot, or if blocks are missing. */
  bool insertDiff(const mrpt::obs::CObservationMapDiff& diff);
  /** Inserts beams with the sensor model of insertionOptions. */
  void insertScan(const std::vector<octomap::point3d>& ends, const octomap::point3d& origin);

  friend struct mrpt::fusion::SourcesOfMap;
  std::unique_ptr<octomap::OcTree> m_octree;
  TreeState m_tree_state{0};
  mrpt::fusion::Sources m_sources;
  uint64_t m_sources_hash = 0;  //!< Hash of the voxels that have these sources
  std::shared_ptr<const mrpt::fusion::MapReplica> m_robot_map;  //!< What diffs gave; null: none
  std::shared_ptr<mrpt::fusion::MapPublisher> m_publisher;      //!< Null: the map is not sent
  mutable std::shared_ptr<const CSimplePointsMap> m_points;     //!< Last points; atomic access
};

}  // namespace mrpt::maps

namespace mrpt::fusion {

/** Returns the CProbOctoMap that a map is, holds or converts to. A COctoMap, a CColouredOctoMap and
 * a COccupancyGridMap3D are converted. In a CMultiMetricMap, a CProbOctoMap comes first, then the
 * other kinds in this order; of several maps of a kind, the first is taken. A CProbOctoMap is not
 * copied: the result is valid as long as \a map. Null if there is no such map. */
MRPT_FUSION_API std::shared_ptr<const mrpt::maps::CProbOctoMap> asProbOctoMap(
    const mrpt::maps::CMetricMap& map);
/** \overload
 * The result keeps \a map alive. */
MRPT_FUSION_API std::shared_ptr<const mrpt::maps::CProbOctoMap> asProbOctoMap(
    const mrpt::maps::CMetricMap::ConstPtr& map);

}  // namespace mrpt::fusion
