// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CRawlog.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>

#include <memory>
#include <string>

/** \file
 * Rawlogs as simplemaps. */

namespace map_tests {

/** Every n-th scan of a recording, as keyframes. */
inline mrpt::maps::CSimpleMap keyframesOf(const std::string& rawlog, size_t n) {
  mrpt::obs::CRawlog recording;
  EXPECT_TRUE(recording.loadFromRawLogFile(rawlog));
  mrpt::maps::CSimpleMap frames;
  mrpt::obs::CObservationRobotPose::Ptr robot;
  size_t scans = 0;
  for (const auto& object : recording) {
    if (auto pose = std::dynamic_pointer_cast<mrpt::obs::CObservationRobotPose>(object))
      robot = pose;
    auto scan = std::dynamic_pointer_cast<mrpt::obs::CObservationPointCloud>(object);
    if (!scan || scans++ % n != 0) continue;
    auto frame = mrpt::obs::CSensoryFrame::Create();
    frame->insert(scan);
    frames.insert(mrpt::poses::CPose3DPDFGaussian::Create(robot->pose), frame);
  }
  return frames;
}

}  // namespace map_tests
