// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/config/CLoadableOptions.h>
#include <mrpt/fusion/compat.h>
#include <mrpt/fusion/export.h>
#include <mrpt/maps/CMetricMap.h>
#include <mrpt/maps/COctoMap.h>
#include <mrpt/poses/CPose3D.h>
#include <octomap/OcTree.h>

#include <memory>
#include <string>
#include <vector>

namespace mrpt::maps {

class CColouredOctoMap;
class COccupancyGridMap3D;

/** A 3-D probabilistic occupancy map: an octomap::OcTree as an MRPT metric map that keeps every
 * log-odds value, wherever it goes.
 *
 * It takes the observations, options and .ini keys of mrpt::maps::COctoMap, and differs from it:
 *  - serialization holds every node's log-odds bit for bit, the structure of the tree and the
 * sensor model (COctoMap's keeps one bit per voxel, and changes the map it saves);
 *  - the `sensorPose` of 3-D observations moves their points as well as the ray's origin;
 *  - a 3-D range scan that brings only a range image is projected;
 *  - isEmpty() is true for a fresh map;
 *  - its occupied voxels are points for those who match maps (ICP and others), see
 * getAsSimplePointsMap();
 *  - the octree is within reach: octree().
 *
 * In .ini map definitions it is `probOctoMap`; a key that it does not know, or a value out of its
 * range, is an exception that names section and key:
 * \code
 * [MappingApplication]
 * probOctoMap_count = 1
 * [MappingApplication_probOctoMap_00_creationOpts]
 * resolution = 0.10      // voxel size, m
 * [MappingApplication_probOctoMap_00_insertOpts]
 * maxrange = -1          // m, -1: whole beams
 * pruning = true
 * occupancyThres = 0.5   // probabilities from here on
 * probHit = 0.7
 * probMiss = 0.4
 * clampingThresMin = 0.1192
 * clampingThresMax = 0.971
 * [MappingApplication_probOctoMap_00_likelihoodOpts]
 * decimation = 1         // use one ray in this many
 * \endcode
 */
class MRPT_FUSION_API CProbOctoMap : public CMetricMap {
  DEFINE_SERIALIZABLE(CProbOctoMap, mrpt::maps)

 public:
  /** \param[in] resolution Voxel size, metres. \exception std::exception If not positive. */
  explicit CProbOctoMap(double resolution = 0.10);
  /** Takes over a tree, its sensor model included. */
  explicit CProbOctoMap(std::unique_ptr<octomap::OcTree> tree);
  /** Copies a tree, its sensor model included. */
  explicit CProbOctoMap(const octomap::OcTree& tree);
  /** A map with the same leaves as \a o, see fromOctoMap(). */
  explicit CProbOctoMap(const COctoMap& o);
  /** \overload */
  explicit CProbOctoMap(const CColouredOctoMap& o);
  /** A map of the cells of \a o, see fromOccupancyGrid(). */
  explicit CProbOctoMap(const COccupancyGridMap3D& o);
  /** Copies all of the tree. */
  CProbOctoMap(const CProbOctoMap& o);
  /** Copies all of the tree. */
  CProbOctoMap& operator=(const CProbOctoMap& o);
  /** The other can but be destroyed or assigned to. */
  CProbOctoMap(CProbOctoMap&&) = default;
  /** The other can but be destroyed or assigned to. */
  CProbOctoMap& operator=(CProbOctoMap&&) = default;
  ~CProbOctoMap() override;

  /** Names, meaning and defaults as in COctoMap::TInsertionOptions; probabilities in (0,1). They
   * become the octree's sensor model at each insertion. */
  struct TInsertionOptions : public mrpt::config::CLoadableOptions {
    double maxrange = -1;         //!< Length to which beams are inserted, metres; -1: all of it
    bool pruning = true;          //!< Prune the tree (without loss) after each insertion
    double occupancyThres = 0.5;  //!< Probability from which a voxel is occupied
    double probHit = 0.7;         //!< Probability that a voxel with a hit is occupied
    double probMiss = 0.4;        //!< Probability that a voxel crossed by a beam is occupied
    double clampingThresMin = 0.1192;  //!< Lowest probability that a voxel can reach
    double clampingThresMax = 0.971;   //!< Highest probability that a voxel can reach

    /** Missing keys keep their values. \exception std::exception Naming section and key: an unknown
     * key, or a value that check() refuses; nothing is changed then. */
    void loadFromConfigFile(const mrpt::config::CConfigFileBase& source,
                            const std::string& section) override;
    /** Saves all keys, each with a comment. */
    void saveToConfigFile(mrpt::config::CConfigFileBase& target,
                          const std::string& section) const override;
    /** \exception std::exception Naming the option: a probability not in (0,1), hit or miss not on
     * its side of 0.5, clamping thresholds reversed, a maxrange that is neither -1 nor positive. */
    void check() const;
  };
  using TLikelihoodOptions = COctoMap::TLikelihoodOptions;  //!< As MRPT's
  using TRenderingOptions = COctoMap::TRenderingOptions;    //!< As MRPT's

  TInsertionOptions insertionOptions;    //!< Of insertObservation() and insertPointCloud()
  TLikelihoodOptions likelihoodOptions;  //!< Of computeObservationLikelihood()
  TRenderingOptions renderingOptions;    //!< Of getAsOctoMapVoxels()

  MAP_DEFINITION_START(CProbOctoMap)
  double resolution = 0.10;                                     //!< Voxel size, metres
  mrpt::maps::CProbOctoMap::TInsertionOptions insertionOpts;    //!< insertionOptions
  mrpt::maps::CProbOctoMap::TLikelihoodOptions likelihoodOpts;  //!< likelihoodOptions
  MAP_DEFINITION_END(CProbOctoMap)

  /** @name The octree
   * @{ */
  /** The tree, owned by the map; never null. */
  const octomap::OcTree& octree() const { return *m_octree; }
  octomap::OcTree& octree() { return *m_octree; }  //!< \overload
  /** Replaces the tree by one taken over; the sensor model in insertionOptions becomes its own. */
  void setOctree(std::unique_ptr<octomap::OcTree> tree);

  /** Voxel size, metres. */
  double getResolution() const { return m_octree->getResolution(); }
  /** Number of nodes, inner ones included. */
  size_t size() const { return m_octree->size(); }
  /** Number of leaves, pruned ones counted once. */
  size_t getNumLeafNodes() const { return m_octree->getNumLeafNodes(); }
  size_t memoryUsage() const { return m_octree->memoryUsage(); }  //!< Of the tree, bytes
  /** Lowest corner of the known space's box, metres. */
  void getMetricMin(double& x, double& y, double& z) const { m_octree->getMetricMin(x, y, z); }
  /** Highest corner of the known space's box, metres. */
  void getMetricMax(double& x, double& y, double& z) const { m_octree->getMetricMax(x, y, z); }
  /** Occupancy probability at a point of the map's frame (metres).
   * \return false if the point is unknown; \a prob_occupancy is then untouched. */
  bool getPointOccupancy(float x, float y, float z, double& prob_occupancy) const;
  /** Counts one hit (or miss) in the voxel at a point. */
  void updateVoxel(double x, double y, double z, bool occupied);
  /** Inserts points given in the map's frame, seen from a sensor at (sensor_x,y,z). */
  void insertPointCloud(const CPointsMap& points, float sensor_x, float sensor_y, float sensor_z);
  /** Counts one hit in its voxel for each point, given in the map's frame, that came without the
   * place it was seen from: no space becomes free. */
  void insertPointCloud(const CPointsMap& points);
  /** First occupied voxel along a ray, see COctoMapBase::castRay(). */
  bool castRay(const mrpt::math::TPoint3D& origin, const mrpt::math::TPoint3D& direction,
               mrpt::math::TPoint3D& end, bool ignoreUnknownCells = false,
               double maxRange = -1.0) const;
  /** @} */

  /** @name Conversion
   * @{ */
  /** Replaces this map by a copy of all of \a o that MRPT's public API gives: each leaf's cube and
   * log-odds (exact for 1e-7 < |log-odds| < 20, beyond which the double-valued probability that
   * MRPT returns has lost digits), resolution, sensor model and options; not the colours. \a o is
   * not modified. \exception std::exception If o's voxels do not lie on an octree's grid. */
  void fromOctoMap(const COctoMap& o);
  void fromOctoMap(const CColouredOctoMap& o);  //!< \overload
  /** Replaces the contents of \a o by this map: same leaves' log-odds, sensor model and options.
   * Cost: one root-to-leaf descent per finest voxel, pruned leaves expanded (MRPT offers no other
   * way in). \exception std::exception If a log-odds value has no probability in double precision
   * (|log-odds| > 36). */
  void toOctoMap(COctoMap& o) const;
  /** A map to take colours from. */
  struct ColourSource {
    const CColouredOctoMap& map;  //!< Not owned
    mrpt::poses::CPose3D pose;    //!< In the coloured map's frame
  };
  /** This map as toOctoMap() gives it, where each occupied leaf has the mean colour that the
   * sources have at its voxels: that of the source's occupied voxel at the same place or, as grids
   * that are turned do not lie on each other, the nearest one within half a voxel diagonal (of the
   * larger of the two). So the colours of two maps survive their fusion. Where no source has one it
   * stays unset (white, as octomap has it).
   *
   * A pointer, as a copy of a CColouredOctoMap has no colours: octomap copies the occupancy only.
   * Nor does MRPT's serialization keep colours, or probabilities; the 3-D scene that
   * saveMetricMapRepresentationToFile() writes has the colours. */
  std::shared_ptr<CColouredOctoMap> toColouredOctoMap(
      const std::vector<ColourSource>& sources = {}) const;

  /** Replaces the octree by one of the grid's known cells, of log-odds as the grid has them (whole
   * 16ths); cells at p = 0.5 are unknown. The options and sensor model stay. Nothing is lost but
   * the grid's extent, and its place where that is not on an octree's grid: a cell moves to the
   * voxel that has most of it, by up to half a voxel. \exception std::exception If the cells are no
   * cubes, or reach beyond an octree's grid (2^15 voxels from the origin). */
  void fromOccupancyGrid(const COccupancyGridMap3D& o);
  /** Replaces the cells of \a o by the box of this map's known space; unknown voxels have p = 0.5.
   * (An empty map gives one such cell.)
   * Lost are: log-odds beyond whole 16ths (voxels nearer to 0 than 1/32 become unknown) and beyond
   * +-127/16 (+-32767/16 where MRPT has 16-bit cells), and the sensor model.
   * \exception std::exception If the box has more than 10^8 voxels. */
  void toOccupancyGrid(COccupancyGridMap3D& o) const;
  /** @} */

  /** @name Points and matching
   * The map's points are the centres of its occupied voxels, pruned leaves expanded, in the order
   * of the octree (that of the indices in correspondences). Other maps may be of points, occupancy
   * maps that asProbOctoMap() takes, or sets of these; the functions throw for others.
   * All may be called from several threads at once. Cost: a matching makes the points and MRPT's
   * k-d tree of them at each call.
   * @{ */
  /** The points, made anew at each call. They stay valid, and the same object, until the call after
   * a change of the map, or auxParticleFilterCleanUp(). Never null. \exception std::length_error If
   * there are more than 10^8. */
  const CSimplePointsMap* getAsSimplePointsMap() const override;
  /** Frees the points given out. */
  void auxParticleFilterCleanUp() override;
  /** As CPointsMap has it, with the points of both maps. */
  void determineMatching2D(const CMetricMap* otherMap, const mrpt::poses::CPose2D& otherMapPose,
                           mrpt::tfest::TMatchingPairList& correspondences,
                           const TMatchingParams& params,
                           TMatchingExtraResults& extraResults) const override;
  /** As CPointsMap has it, with the points of both maps. */
  void determineMatching3D(const CMetricMap* otherMap, const mrpt::poses::CPose3D& otherMapPose,
                           mrpt::tfest::TMatchingPairList& correspondences,
                           const TMatchingParams& params,
                           TMatchingExtraResults& extraResults) const override;
  /** The share of the other map's points that have one of this map's within
   * `params.maxDistForCorr` (metres), as CPointsMap has it. */
  float compute3DMatchingRatio(const CMetricMap* otherMap, const mrpt::poses::CPose3D& otherMapPose,
                               const TMatchingRatioParams& params) const override;
  /** To the closest point, in the plane: m^2. One descent of the octree; no points are made.
   * \exception std::exception If there is no occupied voxel. */
  float squareDistanceToClosestCorrespondence(float x0, float y0) const override;
  /** @} */

  /** @name Files
   * @{ */
  /** Loads a `.ot` or `.bt` file, told apart by content; insertionOptions become the tree's model.
   * \exception std::runtime_error "<path>: <reason>". */
  void loadFromOcTreeFile(const std::string& path);
  /** Saves all log-odds as `.ot`, or maximum likelihood as `.bt`, by the path's extension. Either
   * the whole file is written or none. \exception std::runtime_error "<path>: <reason>". */
  void saveToOcTreeFile(const std::string& path) const;
  /** Writes `<prefix>_3D.3Dscene`, as MRPT's maps do, and `<prefix>.ot` with every probability. */
  void saveMetricMapRepresentationToFile(const std::string& filNamePrefix) const override;
  /** @} */

  /** True if nothing is known anywhere. */
  bool isEmpty() const override { return m_octree->size() == 0; }
  std::string asString() const override;  //!< One line: resolution and size
  /** Adds the map's voxels, see getAsOctoMapVoxels(), if genericMapParams say so. */
  void getVisualizationInto(mrpt::fusion::viz::CSetOfObjects& o) const override;
  /** Fills an MRPT voxel object as COctoMap does: same voxel sets, colours and renderingOptions. */
  void getAsOctoMapVoxels(mrpt::fusion::viz::COctoMapVoxels& gl_obj) const;

 protected:
  /** @name What CMetricMap asks of a map
   * @{ */
  void internal_clear() override;  //!< Keeps resolution and options
  /** Points of 2-D and 3-D scans, in metres in the sensor's frame, seen from the sensor.
   * \return false if there are none in an observation of this kind. */
  bool internal_insertObservation(
      const mrpt::obs::CObservation& obs,
      const std::optional<const mrpt::poses::CPose3D>& robotPose = std::nullopt) override;
  /** Sum of the log-probabilities of the voxels at the observation's points. */
  double internal_computeObservationLikelihood(
      const mrpt::obs::CObservation& obs, const mrpt::poses::CPose3D& takenFrom) const override;
  /** True for the observations that can be inserted. */
  bool internal_canComputeObservationLikelihood(const mrpt::obs::CObservation& obs) const override;
  /** @} */

 private:
  void applySensorModel();
  /** After lazy updates, the inner nodes once: a fraction of the cost of updating them each time.
   */
  void finishInsertion();

  std::unique_ptr<octomap::OcTree> m_octree;
  mutable std::shared_ptr<const CSimplePointsMap> m_points;  //!< Last given out; atomic access
};

}  // namespace mrpt::maps

namespace mrpt::fusion {

/** The probabilistic octomap that a map is, holds or converts to: a mrpt::maps::CProbOctoMap or,
 * converted, a COctoMap, CColouredOctoMap or COccupancyGridMap3D; of a CMultiMetricMap, the first
 * of the kind that is named first here. Not a copy where none is needed: the result is then only
 * valid as long as \a map. Null if there is none. */
MRPT_FUSION_API std::shared_ptr<const mrpt::maps::CProbOctoMap> asProbOctoMap(
    const mrpt::maps::CMetricMap& map);
/** \overload
 * Keeps \a map alive as long as the result. */
MRPT_FUSION_API std::shared_ptr<const mrpt::maps::CProbOctoMap> asProbOctoMap(
    const mrpt::maps::CMetricMap::ConstPtr& map);

}  // namespace mrpt::fusion
