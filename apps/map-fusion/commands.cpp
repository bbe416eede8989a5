// SPDX-License-Identifier: BSD-3-Clause
#include "commands.h"

#include <mrpt/config/CConfigFile.h>
#include <mrpt/core/format.h>
#include <mrpt/fusion/edge_octree.h>
#include <mrpt/fusion/many_maps.h>
#include <mrpt/system/CTicTac.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>

#include "fusion_base/error_text.h"
#include "fusion_base/files.h"
#include "fusion_octree/files.h"
#include "fusion_octree/resampling.h"
#include "mrpt_maps.h"
#include "output.h"
#include "pose.h"
#include "report.h"

using mrpt::fusion::EdgeVoxels;
using mrpt::poses::CPose3D;

namespace {

constexpr const char* kMatchingSection = "ProbabilisticMapMatching";

bool isOcTree(const std::string& path) {
  return mrpt::fusion::withPath(
      path, [&] { return mrpt::fusion::isOcTreeFile(mrpt::fusion::beginningOf(path)); });
}

/** What map a file of any kind holds. \exception std::runtime_error "<path>: <reason>". */
LoadedMap loadAnyMap(const std::string& path, const mrpt::fusion::BuildParams& params) {
  if (!isOcTree(path)) return mrptMaps().load(path, params);
  return mrpt::fusion::withPath(path, [&]() -> LoadedMap {
    return {mrpt::fusion::parseOcTreeFile(mrpt::fusion::readFileBytes(path)), nullptr, nullptr};
  });
}

/** The maps of a recorded mission; none if it is something else. */
std::vector<Robot> loadMission(const std::string& path) {
  return isOcTree(path) ? std::vector<Robot>() : mrptMaps().loadMission(path);
}

/** As `.ot` or `.bt` by extension, else as MRPT serializes it. */
void saveMap(const std::shared_ptr<const octomap::OcTree>& map, const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension();
  if (extension == ".ot" || extension == ".bt")
    mrpt::fusion::saveOcTree(*map, path);
  else
    mrptMaps().save({map, nullptr, nullptr}, path);
}

/** What robots are called whose maps are in files of their own: as the files are, and where several
 * files are called alike, by the folders that they are in, too. */
std::vector<std::string> namesOf(const std::vector<std::string>& paths) {
  namespace fs = std::filesystem;
  std::vector<std::string> names;
  std::vector<fs::path> files, folders;
  for (const auto& path : paths) {
    files.push_back(fs::absolute(path).lexically_normal());
    folders.push_back(files.back().parent_path());
    names.push_back(files.back().filename().replace_extension().string());
  }
  std::vector<size_t> alike;
  do {
    alike.clear();
    for (size_t i = 0; i < paths.size(); i++)
      for (size_t j = 0; j < paths.size(); j++)
        if (names[i] == names[j] && files[i] != files[j] && folders[i].has_relative_path()) {
          alike.push_back(i);
          break;
        }
    for (const size_t i : alike) {
      names[i] = folders[i].filename().string() + "_" + names[i];
      folders[i] = folders[i].parent_path();
    }
  } while (!alike.empty());
  return names;
}

/** One run of a subcommand: its settings, its maps, its report. */
class Run {
 public:
  explicit Run(const Arguments& args) : args_(args), progress_(!args.quiet) {
    report_.command = args.command;
    std::vector<std::string> inputs = args.maps;
    inputs.insert(inputs.end(), {args.config, args.init, args.pose});
    for (const auto& path : {args.output, args.pose_out, args.picture, args.scene, args.json})
      if (!path.empty()) checkWritable(path, inputs);
    if (!args.config.empty()) mrpt::fusion::withPath(args.config, [this] { loadConfig(); });
    if (args.full_6dof) options_.match.search.rotations = mrpt::fusion::SearchRotations::All;
    on_iteration_ = [this](const mrpt::fusion::IterationRecord& i) {
      const char* level = i.level == mrpt::fusion::Level::Edge ? "edges" : "voxels";
      const std::string text =
          mrpt::format("matching %s: %zu pairs, rms distance %.3f m, step %.4f m", level, i.pairs,
                       std::sqrt(i.mse), i.step_translation);
      if (args_.verbose)
        std::cerr << text << "\n";
      else
        progress_.show(text);
    };
    clock_.Tic();
  }

  int fuse() {
    if (args_.maps.size() != 2) return fuseMany();
    loadBoth();
    const bool accepted = matchMaps();
    if (accepted || args_.force) {
      mergeMaps();
      saveFused();
    } else {
      std::cerr << "map-fusion: the match was rejected, nothing was merged (--force to merge)\n";
    }
    draw();
    return finish(accepted);
  }

  int match() {
    loadBoth();
    const bool accepted = matchMaps();
    draw();
    return finish(accepted);
  }

  int evaluate() {
    loadBoth();
    report_.match = mrpt::fusion::evaluate(a_.view(), b_.view(), report_.pose->mean, options_);
    report_.pose = report_.match->pose;
    step("evaluate");
    draw();
    return finish(report_.match->evaluation.accepted);
  }

  int merge() {
    loadBoth();
    mergeMaps();
    saveFused();
    draw();
    return finish(true);
  }

  int edges() {
    const auto edges = std::make_shared<const EdgeVoxels>(edgesOf(load("map", args_.maps[0])));
    report_.edges = edges->size();
    step("edges");
    if (std::filesystem::path(args_.output).extension() == ".ply")
      mrpt::fusion::writeFileAtomically(args_.output, toPly(*edges));
    else
      mrptMaps().save({nullptr, edges, nullptr}, args_.output);
    step("save");
    return finish(true);
  }

  int transform() {
    const CPose3D pose = parsePose(args_.pose);
    const LoadedMap map = load("map", args_.maps[0]);
    const double resolution = args_.resolution > 0 ? args_.resolution : map.octree->getResolution();
    const std::shared_ptr<const octomap::OcTree> moved =
        mrpt::fusion::transformOcTree(*map.octree, mrpt::fusion::toEigen(pose), resolution);
    step("transform");
    saveMap(moved, args_.output);
    step("save");
    report_.maps.push_back(reportOn("transformed", args_.output, *moved));
    return finish(true);
  }

  int build() {
    const auto built = mrptMaps().build(args_.maps[0], buildParams());
    progress_.clear();
    step("build");
    mrptMaps().save(built.map, args_.output);
    step("save");
    report_.observations = {built.inserted, built.ignored};
    if (built.map.octree) report_.maps.push_back(reportOn("map", args_.output, *built.map.octree));
    return finish(true);
  }

  int pack() {
    const auto robots = loadRobots();
    mrptMaps().saveMission(robots, args_.output);
    step("save");
    if (std::filesystem::is_regular_file(args_.output))  // not a pipe
      report_.bytes = std::filesystem::file_size(args_.output);
    return finish(true);
  }

  int info() {
    const auto robots = loadMission(args_.maps[0]);
    for (const auto& robot : robots)
      report_.maps.push_back(reportOn(robot.name, args_.maps[0], *robot.map.octree));
    if (robots.empty()) load("map", args_.maps[0]);
    step("load");
    return finish(true);
  }

 private:
  void loadConfig() {
    mrpt::fusion::readFileBytes(args_.config);  // MRPT takes a missing file for an empty one
    config_ = std::make_unique<mrpt::config::CConfigFile>(args_.config);
    const bool has_map = config_->sectionExists(args_.section);
    const bool has_matching = config_->sectionExists(kMatchingSection);
    if (!has_map && !has_matching)
      throw std::runtime_error("has no section [" + std::string(kMatchingSection) + "] nor [" +
                               args_.section + "]");
    if (has_matching) options_.loadFromConfigFile(*config_, kMatchingSection);
  }

  mrpt::fusion::BuildParams buildParams() {
    mrpt::fusion::BuildParams params;
    if (config_ && config_->sectionExists(args_.section)) params.config = config_.get();
    params.section = args_.section;
    params.progress = [this](size_t n) {
      progress_.show("building: " + std::to_string(n) + " observations");
    };
    return params;
  }

  LoadedMap load(const std::string& role, const std::string& path) {
    progress_.show("loading " + path);
    LoadedMap map = loadAnyMap(path, buildParams());
    progress_.clear();
    report_.maps.push_back(reportOn(role, path, *map.octree));
    if (args_.command != "info" && report_.maps.back().statistics.occupied == 0)
      throw std::runtime_error(path + ": the map has no occupied voxel");
    step("load");
    return map;
  }

  /** The structural edges of a map that is not edges alone. */
  EdgeVoxels edgesOf(const LoadedMap& map) const {
    return extractEdges(mrpt::fusion::extractOccupiedVoxels(map.view().wholeMap()),
                        options_.match.edges);
  }

  /** The maps of all robots: of recorded missions, and of files with one map each. */
  std::vector<Robot> loadRobots() {
    std::vector<Robot> robots;
    const std::vector<std::string> names = namesOf(args_.maps);
    for (size_t i = 0; i < names.size(); i++) {
      const std::string& path = args_.maps[i];
      progress_.show("loading " + path);
      auto of_file = loadMission(path);
      for (const Robot& robot : of_file)
        report_.maps.push_back(reportOn(robot.name, path, *robot.map.octree));
      if (of_file.empty()) {
        Robot& robot = of_file.emplace_back();
        robot.name = names[i];
        robot.map = load(robot.name, path);
      }
      for (Robot& robot : of_file) {
        const bool twice = std::any_of(robots.begin(), robots.end(),
                                       [&](const auto& other) { return other.name == robot.name; });
        if (twice)
          throw std::runtime_error(path + ": there is another map of '" + robot.name + "'");
        if (args_.edges_only)
          robot.map = {nullptr, std::make_shared<const EdgeVoxels>(edgesOf(robot.map)), nullptr};
        robots.push_back(robot);
      }
    }
    step("load");
    progress_.clear();
    return robots;
  }

  int fuseMany() {
    const auto robots = loadRobots();
    if (robots.size() < 2)
      throw std::runtime_error(
          args_.maps[0] + ": holds one map; two are needed, or a rawlog of several robots' maps");
    choosePolicy();
    std::vector<mrpt::fusion::RobotMap> maps;
    maps.reserve(robots.size());
    for (const Robot& robot : robots) maps.push_back({robot.name, robot.map.view(), robot.pose});
    auto result = mrpt::fusion::fuseMaps(
        maps, options_, args_.force,
        [&](const std::string& robot, size_t joined) {
          progress_.show("matching " + robot + " with " + std::to_string(joined) + " joined maps");
        },
        on_iteration_);
    progress_.clear();
    step("fuse");
    fused_ = std::move(result.map);
    report_.members = std::move(result.members);
    const auto joined = std::count_if(report_.members.begin(), report_.members.end(),
                                      [](const auto& m) { return m.joined; });
    const bool is_mergeable =
        std::any_of(report_.members.begin(), report_.members.end(),
                    [](const auto& m) { return m.hasMatch() && !m.info.by_edges; });
    if (joined > 1)
      saveFused();
    else if (is_mergeable)
      std::cerr << "map-fusion: no match was accepted, nothing was merged (--force to merge)\n";
    else
      std::cerr << "map-fusion: nothing was merged: edges alone never are, and one map is whole\n";
    const bool accepted =
        std::all_of(report_.members.begin(), report_.members.end(), [](const auto& m) {
          return m.info.by_edges || !m.hasMatch() || m.info.evaluation.accepted;
        });
    return finish(joined > 1 && accepted);
  }

  void choosePolicy() {
    for (const auto& [policy, name] : mrpt::fusion::mergePolicyNames())
      if (args_.policy == name) options_.merge.policy = policy;
    for (const auto& [policy, name] : mrpt::fusion::mergePolicyNames())
      if (options_.merge.policy == policy) report_.policy = name;
  }

  void loadBoth() {
    if (!args_.init.empty()) report_.initial_pose = parsePose(args_.init);
    if (!args_.pose.empty()) report_.pose.emplace().mean = parsePose(args_.pose);
    a_ = load("a", args_.maps[0]);
    b_ = load("b", args_.maps[1]);
  }

  mrpt::poses::CPose3DPDFGaussian prior() const {
    if (!report_.initial_pose) return mrpt::fusion::noGuess();
    mrpt::poses::CPose3DPDFGaussian guess(*report_.initial_pose);
    if (args_.init_sigma.empty()) return guess;
    const double metres = std::max(args_.init_sigma[0], 1e-3);  // all zero: as configured
    const double yaw = mrpt::DEG2RAD(args_.init_sigma[1]);
    for (int i = 0; i < 3; i++) guess.cov(i, i) = metres * metres;
    guess.cov(3, 3) = yaw * yaw;
    return guess;
  }

  bool matchMaps() {
    progress_.show("extracting edges");
    report_.match = mrpt::fusion::align(a_.view(), b_.view(), prior(), options_, on_iteration_);
    progress_.clear();
    const auto& info = *report_.match;
    report_.pose = info.pose;
    report_.seconds.emplace_back("features", info.seconds_features);
    report_.seconds.emplace_back("match", info.seconds_matching);
    report_.seconds.emplace_back("evaluate", info.seconds_evaluation);
    clock_.Tic();
    if (!args_.pose_out.empty())
      mrpt::fusion::writeFileAtomically(args_.pose_out, toMatrixText(report_.pose->mean));
    return info.evaluation.accepted;
  }

  void mergeMaps() {
    progress_.show("merging");
    choosePolicy();
    fused_ = mrpt::fusion::mergeMaps(a_.view().wholeMap(), b_.view().wholeMap(),
                                     mrpt::fusion::toEigen(report_.pose->mean), options_.merge);
    progress_.clear();
    step("merge");
  }

  void saveFused() {
    saveMap(fused_, args_.output);
    step("save");
    report_.maps.push_back(reportOn("fused", args_.output, *fused_));
  }

  /** What was found, to look at. */
  void draw() {
    if (!args_.picture.empty()) drawPicture();
    if (!args_.scene.empty()) drawScene();
  }

  void drawScene() {
    progress_.show("drawing");
    const EdgeVoxels edges_a = a_.edges ? *a_.edges : edgesOf(a_);
    const EdgeVoxels edges_b = b_.edges ? *b_.edges : edgesOf(b_);
    const mrpt::fusion::Pairs none;
    const mrpt::fusion::FusionView view{*a_.octree,
                                        *b_.octree,
                                        report_.pose->mean,
                                        report_.match ? report_.match->match.pairs : none,
                                        edges_a,
                                        edges_b,
                                        options_.evaluation.inlier_mahalanobis,
                                        fused_.get()};
    mrptMaps().drawScene(view, args_.scene);
    progress_.clear();
    step("scene");
  }

  void drawPicture() {
    std::vector<TopViewPanel> panels;
    if (report_.initial_pose)
      panels.push_back({"initial guess", mrpt::fusion::toEigen(*report_.initial_pose)});
    const bool judged = report_.match.has_value();
    panels.push_back({!judged                              ? "at the given pose"
                      : report_.match->evaluation.accepted ? "result: accepted"
                                                           : "result: rejected",
                      mrpt::fusion::toEigen(report_.pose->mean)});
    mrptMaps().drawPicture(mrpt::fusion::extractOccupiedVoxels(*a_.octree),
                           mrpt::fusion::extractOccupiedVoxels(*b_.octree), panels, args_.picture);
    step("picture");
  }

  void step(const char* name) {
    auto& seconds = report_.seconds;
    const double elapsed = clock_.Tac();
    if (!seconds.empty() && seconds.back().first == name)
      seconds.back().second += elapsed;
    else
      seconds.emplace_back(name, elapsed);
    clock_.Tic();
  }

  int finish(bool accepted) {
    const bool is_stdout_taken = isStandardOutput(args_.output) || isStandardOutput(args_.json);
    if (!args_.quiet) print(report_, is_stdout_taken ? std::cerr : std::cout);
    if (!args_.json.empty()) mrpt::fusion::writeFileAtomically(args_.json, toJson(report_));
    return accepted ? kDone : kRejected;
  }

  const Arguments& args_;
  Progress progress_;
  std::unique_ptr<mrpt::config::CConfigFile> config_;
  mrpt::fusion::Options options_;
  mrpt::fusion::OnIteration on_iteration_;
  mrpt::system::CTicTac clock_;
  LoadedMap a_, b_;
  std::shared_ptr<const octomap::OcTree> fused_;
  Report report_;
};

}  // namespace

int run(const Arguments& arguments) {
  static const std::map<std::string, int (Run::*)()> commands = {
      {"fuse", &Run::fuse},   {"match", &Run::match}, {"evaluate", &Run::evaluate},
      {"merge", &Run::merge}, {"edges", &Run::edges}, {"transform", &Run::transform},
      {"build", &Run::build}, {"pack", &Run::pack},   {"info", &Run::info}};
  Run run(arguments);
  const int status = (run.*commands.at(arguments.command))();
  // To free maps of millions of nodes takes seconds; the system takes the whole process back at
  // once.
  if (!std::cout.flush()) throw std::runtime_error("standard output: cannot be written");
  std::_Exit(status);
}
