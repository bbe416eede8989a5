// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

/** \file
 * Settings and a recording for MRPT's program icp-slam. */

/** MRPT's recording of a laser scanner on a round of a real building. */
inline const std::string kRoundOfABuilding =
    "'/usr/share/mrpt/datasets/2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog'";

/** Settings with which icp-slam makes a CProbOctoMap beside the points that it matches. */
inline const std::string kIcpSlamSettings = R"([ICP]
maxIterations = 100
thresholdDist = 0.3
thresholdAng_DEG = 15
ALFA = 0.5
smallestThresholdDist = 0.05
ICP_algorithm = icpClassic
corresponding_points_decimation = 1
[MappingApplication]
rawlog_offset = 0
logOutput_dir = log
LOG_FREQUENCY = 1000
SAVE_3D_SCENE = false
SAVE_POSE_LOG = false
CAMERA_3DSCENE_FOLLOWS_ROBOT = false
SHOW_PROGRESS_3D_REAL_TIME = false
SHOW_PROGRESS_3D_REAL_TIME_DELAY_MS = 0
SHOW_LASER_SCANS_3D = false
localizationLinDistance = 0.1
localizationAngDistance = 5
insertionLinDistance = 1.0
insertionAngDistance = 15.0
minICPgoodnessToAccept = 0.2
matchAgainstTheGrid = false
pointsMap_count = 1
probOctoMap_count = 1
[MappingApplication_pointsMap_00_insertOpts]
minDistBetweenLaserPoints = 0.05
[MappingApplication_probOctoMap_00_creationOpts]
resolution = 0.2
)";
