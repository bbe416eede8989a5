// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of reading and writing whole files. */
#include "fusion_base/files.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/file_tools.h"

using namespace map_tests;
using mrpt::fusion::beginningOf;
using mrpt::fusion::readFileBytes;
using mrpt::fusion::writeFileAtomically;

TEST(Files, ReadFileBytesSaysWhatIsWrong) {
  const TempDir dir;
  writeRaw(dir.path("bytes"), std::string("a\0\n\xff", 4));
  EXPECT_EQ(std::string("a\0\n\xff", 4), readFileBytes(dir.path("bytes")));
  writeRaw(dir.path("nothing"), "");
  EXPECT_THROW(readFileBytes(dir.path("nothing")), std::runtime_error);
  EXPECT_THROW(readFileBytes(dir.path("missing")), std::runtime_error);
  EXPECT_THROW(readFileBytes(dir.path("")), std::runtime_error);
}

TEST(Files, WriteFileAtomicallyCreatesAndReplaces) {
  const TempDir dir;
  const std::string path = dir.path("map.ot");
  const std::string large(3 << 20, 'x');
  for (const std::string& bytes :
       {std::string("first"), large, std::string(), std::string("b\0", 2)}) {
    writeFileAtomically(path, bytes);
    EXPECT_EQ(bytes, readRaw(path));
    EXPECT_EQ(std::vector<std::string>{"map.ot"}, dir.files());
  }
}

TEST(Files, AWrittenFileHasTheRightsOfAnyNewFile) {
  const TempDir dir;
  const mode_t old_mask = ::umask(027);
  writeFileAtomically(dir.path("map.ot"), "x");
  const mode_t mask = ::umask(old_mask);
  EXPECT_EQ(mode_t{027}, mask);
  struct stat st {};
  ASSERT_EQ(0, ::stat(dir.path("map.ot").c_str(), &st));
  EXPECT_EQ(mode_t{0640}, st.st_mode & 0777);
}

TEST(Files, AFailedWriteKeepsTheOldFileAndLeavesNoOther) {
  const TempDir dir;
  const std::string path = dir.path("map.ot");
  writeFileAtomically(path, "the old map");

  // A limit on the size of files stands for a full disk: part of the data is written, then no more.
  rlimit old_limit{};
  ASSERT_EQ(0, ::getrlimit(RLIMIT_FSIZE, &old_limit));
  rlimit limit = old_limit;
  limit.rlim_cur = 1000;
  auto* const old_handler = ::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(0, ::setrlimit(RLIMIT_FSIZE, &limit));
  const std::string error = errorOf([&] { writeFileAtomically(path, std::string(5000, 'n')); });
  ASSERT_EQ(0, ::setrlimit(RLIMIT_FSIZE, &old_limit));
  ::signal(SIGXFSZ, old_handler);

  EXPECT_EQ(0U, error.find(path + ": ")) << error;
  EXPECT_EQ("the old map", readRaw(path));
  EXPECT_EQ(std::vector<std::string>{"map.ot"}, dir.files());
}

TEST(Files, AFileThatIsGivenUpHalfwayLeavesNothing) {
  const TempDir dir;
  const std::string path = dir.path("map.ot");
  const auto giveUp = [](const mrpt::fusion::ByteSink& sink) {
    sink(std::string(100, 'x'));
    throw std::length_error("given up");
  };
  EXPECT_THROW(writeFileAtomically(path, giveUp), std::length_error);
  EXPECT_TRUE(dir.files().empty());
  writeFileAtomically(path, [](const auto& sink) {
    sink("in ");
    sink("pieces");
  });
  EXPECT_EQ("in pieces", readRaw(path));
}

TEST(Files, WritingIntoAMissingDirectoryIsAnError) {
  const TempDir dir;
  EXPECT_NE(std::string::npos, errorOf([&] {
                                 writeFileAtomically(dir.path("none/map.ot"), "x");
                               }).find("No such file or directory"));
  EXPECT_TRUE(dir.files().empty());
}

TEST(Files, WritingOverADirectoryIsAnError) {
  const TempDir dir;
  std::filesystem::create_directory(dir.path("map.ot"));
  EXPECT_THROW(writeFileAtomically(dir.path("map.ot"), "x"), std::runtime_error);
  EXPECT_EQ(std::vector<std::string>{"map.ot"}, dir.files());
  EXPECT_TRUE(std::filesystem::is_directory(dir.path("map.ot")));
}

TEST(Files, OfALinkWhatItLeadsToIsReplaced) {
  const TempDir dir;
  writeFileAtomically(dir.path("file"), "before");
  std::filesystem::create_symlink("file", dir.path("link"));
  writeFileAtomically(dir.path("link"), "after");
  EXPECT_EQ(readFileBytes(dir.path("file")), "after");
  EXPECT_TRUE(std::filesystem::is_symlink(dir.path("link")));
  EXPECT_EQ((std::vector<std::string>{"file", "link"}), dir.files());
}

TEST(Files, APipeIsNoMap) {
  const TempDir dir;
  ASSERT_EQ(::mkfifo(dir.path("pipe").c_str(), 0600), 0);
  const std::string error = errorOf([&] { beginningOf(dir.path("pipe")); });
  EXPECT_NE(std::string::npos, error.find("pipe")) << error;
}

TEST(Files, ADeviceIsWrittenToNotReplaced) {
  const TempDir dir;  // of links, so that it is never the machine's own devices that are at stake
  for (const char* name : {"null", "full"}) {
    const std::string device = std::string("/dev/") + name;
    if (!std::filesystem::is_character_file(device)) GTEST_SKIP() << device << " is no device";
    std::filesystem::create_symlink(device, dir.path(name));
  }
  EXPECT_NO_THROW(writeFileAtomically(dir.path("null"), "x"));
  const std::string error = errorOf([&] { writeFileAtomically(dir.path("full"), "x"); });
  EXPECT_NE(std::string::npos, error.find("No space left")) << error;
  EXPECT_EQ((std::vector<std::string>{"full", "null"}), dir.files());
  for (const auto& name : dir.files()) EXPECT_TRUE(std::filesystem::is_symlink(dir.path(name)));
}
