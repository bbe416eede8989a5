// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Defines the subcommands with their options and help texts. */

#include "command_definitions.h"

#include <cmath>
#include <filesystem>

#include "fusion_base/error_text.h"
#include "fusion_base/printable.h"
#include "fusion_link/dds_link.h"
#include "fusion_octree/resolution.h"
#include "output.h"
#include "pose.h"
#include "poses_out.h"
#include "slice_out.h"

namespace map_fusion {

namespace {

/** Makes a check of a number. In contrast to CLI::Range, it rejects NaN. */
CLI::Validator numberIn(double min, double max, const std::string& name) {
  return {[=](const std::string& text) -> std::string {
            double value = std::nan("");
            const bool is_number = CLI::detail::lexical_cast(text, value);
            if (is_number && value >= min && value <= max) return {};
            if (!is_number) return mrpt::fusion::printable(text) + " is not a number";
            return mrpt::fusion::printable(text) + " is not in [" + CLI::detail::to_string(min) +
                   ", " + CLI::detail::to_string(max) + "]";
          },
          name};
}

constexpr int kMaxMaps = 10000;
constexpr double kMostThreads = 1024;
constexpr double kLeastTime = 1e-3, kMostTime = 1e9;  // s
constexpr double kLeastSigma = 1e-6;                  // m, deg
constexpr double kMostSigma = 1e6;                    // m, deg
constexpr double kMostHeight = 1e9;                   // m

constexpr const char* kPoseHelp =
    "\"[x y z yaw pitch roll]\" (m, deg), or a file with a 4x4 row-major matrix";
constexpr const char* kMapsHelp =
    "maps: .ot, .bt, MRPT-serialized, point clouds (.pcd, .ply), or recordings from which maps are "
    "built";
constexpr const char* kFusedHelp =
    "fused map in the frame of A: .ot, .bt, or MRPT-serialized (.gridmap, .gridmap.gz). "
    "*.simplemap: the key frames of all maps in the frame of A, if all maps are simplemaps";
constexpr const char* kResolutionHelp =
    "voxel size (m) of files that state none: point clouds (default: 0.1), and the data of "
    "octomap_msgs/Octomap without a header";

/** Adds subcommands, and the options that several subcommands share. */
class CommandLine {
 public:
  CommandLine(CLI::App& app, Arguments& args) : app_(app), args_(args) {}

  CLI::App* add(const std::string& name, const std::string& what, const std::string& example) {
    auto* sub = app_.add_subcommand(name, what);
    sub->footer("Example:\n  " + example);
    sub->add_option("--config", args_.config,
                    "settings: section [ProbabilisticMapMatching] and, for recordings, definitions "
                    "of MRPT maps")
        ->type_name("FILE.ini");
    sub->add_option("--section", args_.section, "section of --config with the map definition")
        ->capture_default_str();
    sub->add_option("--json", args_.json, "write all figures of the run to FILE")
        ->type_name("FILE");
    sub->add_option("--threads", args_.threads,
                    "number of threads; the result does not depend on it (default: all cores)")
        ->check(numberIn(1, kMostThreads, "N"));
    auto* quiet = sub->add_flag("-q,--quiet", args_.quiet, "print neither summary nor progress");
    sub->add_flag("-v,--verbose", args_.verbose, "print each iteration")->excludes(quiet);
    return sub;
  }
  void inputs(CLI::App* sub, const std::string& names, int least, int most,
              const std::string& help = kMapsHelp,
              const std::string& resolution_help = kResolutionHelp) {
    sub->add_option(names, args_.maps, help)
        ->required()
        ->expected(least, most)
        ->check(CLI::Validator(
            [](const std::string& path) -> std::string {
              return path == "-" ? "maps are read from files, not from standard input (a file of "
                                   "this name is ./-)"
                                 : "";
            },
            ""));
    reading(sub, resolution_help);
  }
  void reading(CLI::App* sub, const std::string& resolution_help = kResolutionHelp) {
    sub->add_option("--resolution", args_.resolution, resolution_help)
        ->check(numberIn(mrpt::fusion::kMinResolution, mrpt::fusion::kMaxResolution, "M"));
    sub->add_option("--sensor-origin", args_.sensor_origin,
                    "position of the sensor in the frame of the point clouds, m: the space between "
                    "the sensor and the points is free (default: VIEWPOINT of a .pcd, if it is not "
                    "0 0 0 1 0 0 0). Without a position, a point cloud has no free space")
        ->type_name("\"X Y Z\"")
        ->check(CLI::Validator(
            [](const std::string& text) -> std::string {
              try {
                parsePoint(text);
                return {};
              } catch (const std::exception& e) {
                return mrpt::fusion::messageOf(e);
              }
            },
            ""));
  }
  void output(CLI::App* sub, const std::string& what) {
    sub->add_option("-o,--output", args_.output, what + "; - is standard output")
        ->required()
        ->type_name("FILE");
  }
  /** \return The option of the guess. */
  CLI::Option* init(CLI::App* sub) {
    auto* guess =
        sub->add_option("--init", args_.init,
                        "initial guess of the pose of B in A's frame: " + std::string(kPoseHelp) +
                            ". Without --init, all positions and headings are searched")
            ->type_name("POSE");
    sub->add_option(
           "--init-sigma", args_.init_sigma,
           "standard deviations of the position (m) and the heading (deg) of the guess. "
           "Poses farther than 3 standard deviations from the guess are neither searched nor "
           "accepted (default: ranges of the settings)")
        ->type_name("M DEG")
        ->expected(2)
        ->check(numberIn(kLeastSigma, kMostSigma, "NUMBER"))
        ->needs(guess);
    sub->add_flag("--full-6dof", args_.full_6dof,
                  "search all roll and pitch angles, too. Without --full-6dof, both maps must be "
                  "upright to within a few degrees")
        ->excludes(guess);
    sub->add_option("--pose-out", args_.pose_out,
                    "write the estimated pose to FILE as a 4x4 matrix (exactly two maps)")
        ->type_name("FILE");
    return guess;
  }
  void team(CLI::App* sub, CLI::Option* guess) {
    sub->add_option("--priors", args_.priors,
                    "guesses of poses: a g2o file with EDGE_SE3:QUAT or VERTEX_SE3:QUAT. The ids "
                    "are the indices of the maps in the order given, from 0")
        ->type_name("FILE.g2o")
        ->excludes(guess);
    posesOut(sub);
  }
  void posesOut(CLI::App* sub) {
    sub->add_option("--poses-out", args_.poses_out,
                    "write the poses of all placed robots to FILE: .g2o, .graph (MRPT), .tum (time "
                    "is the index of the map) or .yaml")
        ->type_name("FILE")
        ->check(CLI::Validator(
            [](const std::string& path) {
              return isPosesFile(path) ? std::string()
                                       : mrpt::fusion::printable(path) +
                                             " does not end in .g2o, .graph, .tum or .yaml";
            },
            "FILE"));
  }
  void page(CLI::App* sub) {
    sub->add_option(
           "--report", args_.page,
           "write a page: one HTML file with the maps in 3-D, the verdict and all figures, "
           "for any browser, without network; - is standard output")
        ->type_name("FILE.html");
  }
  void link(CLI::App* sub) {
    sub->add_option("--robot", args_.robot, "name of this robot, unlike the names of all others")
        ->required()
        ->type_name("NAME");
    sub->add_option("--map", args_.maps,
                    "map of this robot, read again when it changes (default: none, as at a base "
                    "station): .ot, .bt, MRPT-serialized, or a recording")
        ->type_name("FILE")
        ->expected(1);
    sub->add_option("--domain", args_.domain, "robots of the same DDS domain meet")
        ->check(numberIn(0, mrpt::fusion::kMostDomain, "N"))
        ->capture_default_str();
    sub->add_option("--peer", args_.peers,
                    "address of another robot; may be given several times. Without --peer, robots "
                    "find each other by multicast")
        ->type_name("ADDRESS")
        ->allow_extra_args(false);
    sub->add_option("--journal", args_.journal,
                    "folder that keeps what has arrived, so that the robot continues after a crash")
        ->type_name("DIR");
    sub->add_option("--record", args_.recording,
                    "rawlog to which all changes of all maps are appended: a mission for info, "
                    "fuse, match and build")
        ->type_name("FILE.rawlog")
        ->check(CLI::Validator(
            [](const std::string& path) {
              return std::filesystem::path(path).extension() == ".rawlog"
                         ? std::string()
                         : mrpt::fusion::printable(path) + " does not end in .rawlog";
            },
            "FILE"));
    sub->add_option("--for", args_.seconds, "leave after a time, s (default: at SIGTERM or SIGINT)")
        ->check(numberIn(kLeastTime, kMostTime, "SECONDS"));
    sub->add_option("--until-complete", args_.until_complete,
                    "leave when this robot has N whole maps, with its own, and N - 1 robots have "
                    "the map of this robot")
        ->check(numberIn(1, kMaxMaps, "N"));
  }
  void pose(CLI::App* sub, const std::string& what) {
    sub->add_option("--pose,--init", args_.pose, what + ": " + kPoseHelp)
        ->required()
        ->type_name("POSE");
  }
  void picture(CLI::App* sub) {
    sub->add_option("--picture", args_.picture, "draw both maps from above (exactly two maps)")
        ->type_name("FILE.png");
    sub->add_option("--scene", args_.scene,
                    "write both maps, their edges, the matched pairs and the fused map as a scene "
                    "for SceneViewer3D (exactly two maps)")
        ->type_name("FILE.3Dscene");
    page(sub);
  }
  void slice(CLI::App* sub) {
    sub->add_option("-o,--output", args_.output,
                    "*.pgm: a picture, and *.yaml beside it, for map servers of ROS; *.gridmap, "
                    "*.gridmap.gz: a COccupancyGridMap2D of MRPT with probabilities")
        ->required()
        ->type_name("FILE")
        ->check(CLI::Validator(
            [](const std::string& path) {
              return isSliceFile(path) ? std::string()
                                       : mrpt::fusion::printable(path) +
                                             " does not end in .pgm, .gridmap or .gridmap.gz";
            },
            ""));
    sub->add_option("--heights", args_.heights,
                    "lowest and highest height of the centre of a voxel, m, frame of the map "
                    "(default: all heights, with floors and ceilings)")
        ->type_name("MIN MAX")
        ->expected(2)
        ->check(numberIn(-kMostHeight, kMostHeight, "NUMBER"));
    sub->add_option("--thresholds", args_.thresholds,
                    "*.pgm: probabilities below which a cell is free, and from which on it is "
                    "occupied (default: the threshold of the map, 0.5)")
        ->type_name("FREE OCCUPIED")
        ->expected(2)
        ->check(numberIn(0, 1, "NUMBER"));
  }
  void policy(CLI::App* sub) {
    sub->add_option("--policy", args_.policy,
                    "rule for the value of a voxel that both maps know (default: as in the "
                    "settings)")
        ->check(CLI::IsMember({"relative_entropy", "average", "stitch", "bayes"}));
    sub->add_flag(
        "--independent", args_.independent,
        "count all observations of all maps. Without --independent, no observation counts "
        "twice: not those of maps with the same voxels, and not those of a map that a "
        "fused map in an MRPT-serialized file or a mission already holds");
  }

 private:
  CLI::App& app_;
  Arguments& args_;
};

void addPairCommands(CommandLine& line, Arguments& args) {
  auto* fuse =
      line.add("fuse",
               "Estimate the pose of B in A. If the match is accepted, merge both maps.\n"
               "With more maps, or with a rawlog of the maps of several robots, merge all\n"
               "maps whose matches are accepted",
               "map-fusion fuse a.ot b.ot --init \"[4 1 0 30 0 0]\" -o fused.ot");
  line.inputs(fuse, "A B...", 1, kMaxMaps);
  line.output(fuse, kFusedHelp);
  line.team(fuse, line.init(fuse));
  line.policy(fuse);
  line.picture(fuse);
  fuse->add_flag("--force", args.force, "merge rejected matches, too");

  auto* match = line.add("match", "Estimate the pose of B in A and judge whether it is right",
                         "map-fusion match a.ot b.ot --init guess.txt --pose-out T_a_b.txt");
  line.inputs(match, "A B", 2, 2);
  line.init(match);
  line.picture(match);

  auto* evaluate = line.add("evaluate", "Judge whether a given pose of B in A is right",
                            "map-fusion evaluate a.ot b.ot --pose T_a_b.txt");
  line.inputs(evaluate, "A B", 2, 2);
  line.pose(evaluate, "pose of B in A's frame");
  line.picture(evaluate);

  auto* merge = line.add("merge", "Merge both maps at a given pose of B in A",
                         "map-fusion merge a.ot b.ot --pose T_a_b.txt --policy bayes -o fused.ot");
  line.inputs(merge, "A B", 2, 2);
  line.pose(merge, "pose of B in A's frame");
  line.output(merge, kFusedHelp);
  line.policy(merge);
  line.picture(merge);
}

void addMapCommands(CommandLine& line, Arguments& args) {
  auto* edges = line.add("edges", "Extract the structural edge voxels of a map",
                         "map-fusion edges a.ot -o edges.ply");
  line.inputs(edges, "MAP", 1, 1);
  line.output(edges,
              "*.ply: a point cloud whose normals (nx, ny, nz) are the directions of the edges; "
              "otherwise a CEdgeVoxelMap, which can be matched");

  auto* transform =
      line.add("transform", "Move a map to another frame, onto the grid of that frame",
               "map-fusion transform b.ot --pose \"[1 2 0 90 0 0]\" -o moved.ot");
  line.inputs(
      transform, "MAP", 1, 1, kMapsHelp,
      "voxel size, m (default: as in the map). It is also the " + std::string(kResolutionHelp));
  line.pose(transform, "pose of the map's frame in the new frame");
  line.output(transform, "moved map: .ot, .bt, or MRPT-serialized (.gridmap, .gridmap.gz)");

  auto* slice = line.add(
      "slice",
      "Write the columns of a map as a 2-D grid for navigation: a column is occupied if a voxel\n"
      "of it is occupied, free if its known voxels are free, otherwise unknown",
      "map-fusion slice fused.ot --heights 0.2 1.5 -o map.pgm");
  line.inputs(slice, "MAP", 1, 1);
  line.slice(slice);

  auto* build = line.add(
      "build", "Build a map from a recording (.rawlog, .simplemap) or a point cloud (.pcd, .ply)",
      "map-fusion build run.rawlog --config map.ini -o run.ot");
  line.inputs(build, "RECORDING", 1, 1,
              "recording (.rawlog, .simplemap) or point cloud (.pcd, .ply)");
  line.output(build, "map: .ot, .bt, or MRPT-serialized (.gridmap, .gridmap.gz)");

  auto* pack = line.add("pack", "Write the maps of several robots to one rawlog, compressed",
                        "map-fusion pack robot1.ot robot2.ot -o mission.rawlog");
  line.inputs(pack, "MAPS", 1, kMaxMaps);
  line.output(pack, "rawlog with one CObservationLocalMap per robot, named as the robot's file");
  pack->add_flag("--edges-only", args.edges_only,
                 "write only the structural edges: less than 5 % of the size");
  pack->add_flag("--smallest", args.smallest,
                 "pack by LZMA: 0.9 times the bytes, 10 times the time");

  auto* view = line.add("view",
                        "Show a map, or a page that --report wrote, in the browser.\n"
                        "Without a display, print where the page is",
                        "map-fusion view a.ot");
  line.inputs(view, "MAP|PAGE", 1, 1);
  view->add_option("-o,--output", args.page,
                   "page of the map (default: in a new folder for temporary files); - is standard "
                   "output")
      ->type_name("FILE.html");

  auto* info = line.add("info", "Print the contents of maps", "map-fusion info a.ot");
  line.inputs(info, "MAPS", 1, kMaxMaps);
}

void addTeamCommands(CommandLine& line, Arguments& args) {
  auto* join = line.add("join",
                        "Exchange maps with other robots over a thin link, and fuse them as they\n"
                        "arrive. All robots get the same fused map, in the frame of the first\n"
                        "robot by name",
                        "map-fusion join --robot r1 --map live.ot --domain 7 -o fused.ot");
  line.link(join);
  line.reading(join);
  join->add_option("-o,--output", args.output,
                   "fused map, written when it changes: .ot, .bt, or MRPT-serialized (.gridmap)")
      ->type_name("FILE");
  line.posesOut(join);
  line.policy(join);
  line.page(join);
}

}  // namespace

void defineCommands(CLI::App& app, Arguments& args) {
  app.name("map-fusion");
  app.description("Matches, evaluates and merges 3-D occupancy maps.");
  app.require_subcommand(1);
  app.set_version_flag("--version", "map-fusion " MAP_FUSION_VERSION);
  app.footer(
      "Exit codes: 0 success, and the match (if there is one) is accepted; 1 failure, for example\n"
      "bad input; 2 wrong usage; 3 the match is rejected, or maps of a team are left out.\n"
      "'map-fusion COMMAND --help' describes a command.");
  CommandLine line(app, args);
  addPairCommands(line, args);
  addMapCommands(line, args);
  addTeamCommands(line, args);
}

}  // namespace map_fusion
