// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Parses guesses of poses in g2o files. */

#include "priors.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "fusion_base/error_text.h"
#include "fusion_base/files.h"
#include "fusion_core/registration/perturbations.h"
#include "pose.h"

using mrpt::fusion::Matrix6d;
using mrpt::fusion::Prior;

namespace map_fusion {

namespace {

constexpr size_t kMostBytes = size_t{64} << 20U;
constexpr size_t kPoseNumbers = 7, kInformationNumbers = 21;

/** Splits a line into words. \exception std::runtime_error If there are characters of no text. */
std::vector<std::string> wordsOf(const std::string& line) {
  const auto is_text = [](char c) { return (c >= ' ' && c <= '~') || c == '\t' || c == '\r'; };
  if (!std::all_of(line.begin(), line.end(), is_text))
    throw std::runtime_error("there are characters that belong to no g2o file");
  std::istringstream in(line);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

size_t idOf(const std::string& word, size_t maps) {
  const bool is_number =
      !word.empty() && word.size() <= 9 &&
      std::all_of(word.begin(), word.end(), [](char c) { return c >= '0' && c <= '9'; });
  const size_t id = is_number ? std::stoul(word) : maps;
  if (id >= maps)
    throw std::runtime_error("'" + word.substr(0, 20) + "' is not the index of a map, 0 to " +
                             std::to_string(maps - 1));
  return id;
}

void requireWords(const std::vector<std::string>& words, size_t ids, size_t numbers) {
  if (words.size() != 1 + ids + numbers)
    throw std::runtime_error(words[0] + " needs " + std::to_string(numbers) + " numbers after " +
                             (ids == 1 ? "the id" : "the ids"));
}

/** Parses "x y z qx qy qz qw". */
Eigen::Isometry3d poseOf(const std::vector<std::string>& words, size_t first) {
  double v[kPoseNumbers];
  for (size_t i = 0; i < kPoseNumbers; i++) v[i] = parseNumber(words[first + i]);
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  constexpr double kTolerance = 0.01;  // texts are rounded
  if (!(std::abs(q.norm() - 1) < kTolerance))
    throw std::runtime_error("the quaternion does not have the length 1");
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = q.normalized().toRotationMatrix();
  T.translation() = Eigen::Vector3d(v[0], v[1], v[2]);
  return T;
}

/** Returns the inverse of the upper triangle of an information matrix. */
Matrix6d covarianceOf(const std::vector<std::string>& words, size_t first) {
  Matrix6d information;
  size_t next = first;
  for (int row = 0; row < 6; row++)
    for (int col = row; col < 6; col++)
      information(row, col) = information(col, row) = parseNumber(words[next++]);
  const Eigen::LLT<Matrix6d> cholesky(information);
  const Matrix6d covariance = cholesky.solve(Matrix6d::Identity());
  if (cholesky.info() != Eigen::Success || !covariance.allFinite() ||
      !(covariance.diagonal().minCoeff() > 0))
    throw std::runtime_error("the information matrix is not positive definite");
  return covariance;
}

void parseEdge(const std::vector<std::string>& words, size_t maps, Priors& priors) {
  requireWords(words, 2, kPoseNumbers + kInformationNumbers);
  const size_t from = idOf(words[1], maps), to = idOf(words[2], maps);
  if (from == to) throw std::runtime_error("an edge joins map " + words[1] + " with itself");
  const Eigen::Isometry3d T = poseOf(words, 3);
  const Matrix6d right = covarianceOf(words, 3 + kPoseNumbers);
  // A right perturbation of a pose is a left perturbation of its inverse.
  const bool is_forward = from < to;
  const Eigen::Isometry3d T_a_b = is_forward ? T : T.inverse();
  const Matrix6d left = is_forward ? mrpt::fusion::toLeftCovariance(right, T) : right;
  mrpt::poses::CPose3DPDFGaussian guess(mrpt::fusion::toPose(T_a_b));
  guess.cov = mrpt::math::CMatrixDouble66(mrpt::fusion::toYawPitchRollCovariance(left, T_a_b));
  const auto pair = std::minmax(from, to);
  if (!priors.pairs.emplace(pair, Prior::gaussian(guess)).second)
    throw std::runtime_error("another edge joins maps " + words[1] + " and " + words[2]);
}

void parseVertex(const std::vector<std::string>& words, size_t maps, Priors& priors) {
  requireWords(words, 1, kPoseNumbers);
  const Prior pose = Prior::near(mrpt::fusion::toPose(poseOf(words, 2)));  // checks the range
  if (!priors.poses.emplace(idOf(words[1], maps), pose.guess()).second)
    throw std::runtime_error("there is another vertex " + words[1]);
}

}  // namespace

std::optional<Prior> Priors::of(size_t a, size_t b) const {
  const auto pair = pairs.find({a, b});
  if (pair != pairs.end()) return pair->second;
  const auto in_a = poses.find(a), in_b = poses.find(b);
  if (in_a == poses.end() || in_b == poses.end()) return std::nullopt;
  return Prior::near(in_b->second - in_a->second);
}

Priors parsePriors(const std::string& text, size_t maps) {
  Priors priors;
  std::istringstream in(text);
  std::string line;
  for (size_t number = 1; std::getline(in, line); number++)
    mrpt::fusion::withPath("line " + std::to_string(number), [&] {
      const size_t first = line.find_first_not_of(" \t\r");
      if (first == std::string::npos || line[first] == '#') return;
      const auto words = wordsOf(line);
      if (words[0] == "FIX" || words[0] == "PARAMS_SE3OFFSET") return;
      if (words[0] == "EDGE_SE3:QUAT") return parseEdge(words, maps, priors);
      if (words[0] == "VERTEX_SE3:QUAT") return parseVertex(words, maps, priors);
      throw std::runtime_error("'" + words[0].substr(0, 20) +
                               "' is neither VERTEX_SE3:QUAT nor EDGE_SE3:QUAT");
    });
  if (priors.pairs.empty() && priors.poses.empty())
    throw std::runtime_error("has no VERTEX_SE3:QUAT and no EDGE_SE3:QUAT");
  return priors;
}

Priors loadPriors(const std::string& path, size_t maps) {
  return mrpt::fusion::withPath(
      path, [&] { return parsePriors(mrpt::fusion::readFileBytes(path, kMostBytes), maps); });
}

}  // namespace map_fusion
