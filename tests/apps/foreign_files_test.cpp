// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of files of other formats: the reason says what the file is, and what to do. */

#include <zlib.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "run.h"

namespace {

using namespace std::string_literals;

/** A file of another format. */
struct Foreign {
  std::string name;
  std::string bytes;
  std::string reason;  ///< Part of the message
};

/** Returns bytes of any value, as pictures and packed files have them. */
std::string anyBytes() {
  std::mt19937 rng(1);
  std::string bytes(5000, '\0');
  for (char& c : bytes) c = static_cast<char>(rng());
  return bytes + "\x1b]0;title\x07\x1b[2J\x9b" + "31m";
}

std::vector<Foreign> foreignFiles() {
  return {
      {"room.png", "\x89PNG\r\n\x1a\n"s + std::string("\0\0\0\rIHDR", 8) + anyBytes(), "picture"},
      {"photo.jpg", "\xff\xd8\xff\xe0"s + anyBytes(), "picture"},
      {"cloud.las", "LASF"s + anyBytes(), "point cloud"},
      {"cloud.e57", "ASTM-E57"s + anyBytes(), "point cloud"},
      {"pointer.ot", "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 1445579\n"s,
       "git lfs pull"},
      {"download.bt", "<!DOCTYPE html>\n<html><body>404: Not Found</body></html>\n"s, "web page"},
      {"ros1.bag", "#ROSBAG V2.0\n"s + anyBytes(), "ROS recording"},
      {"ros2.db3", "SQLite format 3\0"s + anyBytes(), "ROS recording"},
      {"ros2.mcap", "\x89MCAP0\r\n"s + anyBytes(), "ROS recording"},
      {"map.pgm", "P5\n100 100\n255\n"s + anyBytes(), "2-D grid map"},
      {"map.yaml", "image: map.pgm\nresolution: 0.05\n"s, "2-D grid map"},
      {"maps.zip", "PK\x03\x04"s + anyBytes(), "unpack"},
      {"notes.txt", "the map of the second floor\n"s, "text file"},
  };
}

class ForeignFiles : public AppTest {
 protected:
  /** The run fails with one line that names the file and holds no control characters. */
  void expectOneLine(const std::string& arguments, const std::string& file,
                     const std::string& reason) const {
    const auto r = mapFusion(arguments);
    EXPECT_EQ(r.code, 1) << arguments;
    EXPECT_EQ(r.out, "") << arguments;
    ASSERT_FALSE(r.err.empty()) << arguments;
    EXPECT_EQ(r.err.back(), '\n') << arguments;
    const std::string line = r.err.substr(0, r.err.size() - 1);
    for (const char c : line) {
      EXPECT_GE(static_cast<unsigned char>(c), ' ') << arguments;
      EXPECT_LT(static_cast<unsigned char>(c), 0x7f) << arguments;
    }
    EXPECT_EQ(line.rfind("map-fusion: " + file + ": ", 0), 0U) << line;
    EXPECT_NE(line.find(reason), std::string::npos) << arguments << "\n" << line;
    EXPECT_LT(line.size(), 500U) << arguments << "\n" << line;
    for (const char* output : {"out.ot", "out.ply", "out.rawlog"})
      EXPECT_FALSE(fs::exists(dir_ / output)) << arguments;
  }

  /** Expects the reason from all commands that read a map. */
  void expectFromAllCommands(const std::string& file, const std::string& reason) const {
    const std::string good = pair("map_a.ot");
    for (const std::string& arguments :
         {"info " + file, "edges " + file + " -o out.ply", "pack " + file + " -o out.rawlog",
          "build " + file + " -o out.ot", "match " + file + " " + good,
          "fuse " + good + " " + file + " -o out.ot", "fuse " + file + " -o out.ot",
          "fuse " + both() + " " + file + " -o out.ot"})
      expectOneLine(arguments, file, reason);
  }
};

TEST_F(ForeignFiles, AreNamedWithAdvice) {
  for (const Foreign& f : foreignFiles()) {
    writeFile(dir_ / f.name, f.bytes);
    expectFromAllCommands(f.name, f.reason);
  }
}

TEST_F(ForeignFiles, AreNamedWhateverTheirNameSays) {
  for (const Foreign& f : foreignFiles())
    for (const std::string name : {"file.ot", "file.bt", "file.rawlog", "file.simplemap"}) {
      writeFile(dir_ / name, f.bytes);
      expectOneLine("info " + name, name, f.reason);
    }
}

TEST_F(ForeignFiles, AreNamedIfTheyArePacked) {
  for (const Foreign& f : foreignFiles()) {
    const std::string name = "packed.gz";
    gzFile file = ::gzopen((dir_ / name).c_str(), "wb");
    ASSERT_NE(file, nullptr);
    ::gzwrite(file, f.bytes.data(), static_cast<unsigned>(f.bytes.size()));
    ::gzclose(file);
    expectOneLine("info " + name, name, f.reason);
  }
}

TEST_F(ForeignFiles, OfAnUnknownFormatGiveOneLineToo) {
  for (const std::string name : {"file", "file.ot", "file.gz", "file.rawlog", "file.simplemap"}) {
    writeFile(dir_ / name, "\x01\x02"s + anyBytes());
    expectFromAllCommands(name, "");
    // Bytes that MRPT takes for the length of a class name
    writeFile(dir_ / name, "\x8f"s + anyBytes());
    expectFromAllCommands(name, "");
  }
}

TEST_F(ForeignFiles, AsPoseOrSettingsGiveOneLine) {
  for (const Foreign& f : foreignFiles()) {
    writeFile(dir_ / f.name, f.bytes);
    const std::string command = f.name == "notes.txt" ? "evaluate " : "match ";
    const std::string pose = command == "match " ? " --init " : " --pose ";
    expectOneLine(command + both() + pose + f.name, f.name, "");
    expectOneLine("match " + both() + " --config " + f.name, f.name, "section");
  }
}

TEST_F(ForeignFiles, MayHaveNamesThatControlATerminal) {
  const auto r = mapFusion("info \"$(printf 'a\\033[2Jb.ot')\"");
  EXPECT_EQ(r.code, 1);
  EXPECT_EQ(r.err.find('\x1b'), std::string::npos);
  EXPECT_NE(r.err.find("a\\x1b[2Jb.ot"), std::string::npos) << r.err;
}

}  // namespace
