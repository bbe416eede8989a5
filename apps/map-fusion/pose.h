// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/math/TPoint3D.h>
#include <mrpt/poses/CPose3D.h>

#include <string>

/** \file
 * Poses on the command line and in text files. */

namespace map_fusion {

/** Parses a pose: "[x y z yaw pitch roll]" (m, deg), or the name of a file with a 4x4 row-major
 * matrix. \exception std::runtime_error "<text or path>: <reason>", also if the matrix is not a
 * rigid transform to within 1e-3. Text files are rounded, so the tolerance is wide. */
mrpt::poses::CPose3D parsePose(const std::string& text);

/** Parses a point: "x y z" (m), with or without square brackets.
 * \exception std::runtime_error "point '<text>' ...: <reason>". */
mrpt::math::TPoint3D parsePoint(const std::string& text);

/** Parses a word. \exception std::runtime_error If it is not a finite number. */
double parseNumber(const std::string& word);

/** Returns the text of a 4x4 row-major matrix file, see parsePose(). */
std::string toMatrixText(const mrpt::poses::CPose3D& pose);

}  // namespace map_fusion
