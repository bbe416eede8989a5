// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/poses/CPose3D.h>

#include <string>

/** A pose from the command line: "[x y z yaw pitch roll]" (m, deg), or the name of a file that
 * holds a 4x4 row-major matrix. \exception std::runtime_error Naming the text or the file, if it is
 * neither or not a rigid transform (to 1e-3, what rounding in a text file leaves). */
mrpt::poses::CPose3D parsePose(const std::string& text);

/** The 4x4 row-major matrix as text, as parsePose() reads it from a file. */
std::string toMatrixText(const mrpt::poses::CPose3D& pose);
