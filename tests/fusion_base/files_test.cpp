// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of reading and writing whole files. */
#include "fusion_base/files.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
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

TEST(Files, AReplacedFileKeepsItsRights) {
  const TempDir dir;
  const std::string path = dir.path("map.ot");
  for (const mode_t rights : {0600U, 0640U, 0666U, 0400U}) {
    writeFileAtomically(path, "old");
    ASSERT_EQ(0, ::chmod(path.c_str(), rights));
    writeFileAtomically(path, [&](const mrpt::fusion::ByteSink& sink) {
      sink("new");
      for (const auto& file : dir.files()) {
        struct stat st {};
        ASSERT_EQ(0, ::stat(dir.path(file).c_str(), &st));
        EXPECT_EQ(0U, st.st_mode & 0777U & ~rights) << file << " can be read by others";
      }
    });
    struct stat st {};
    ASSERT_EQ(0, ::stat(path.c_str(), &st));
    EXPECT_EQ(rights, st.st_mode & 07777U);
    EXPECT_EQ("new", readRaw(path));
    std::filesystem::remove(path);
  }
}

/** Returns the error of a function that writes to a full disk. A limit on the size of files stands
 * for it: part of the data is written, then no more. */
std::string errorOnAFullDisk(const std::function<void()>& write) {
  rlimit old_limit{};
  EXPECT_EQ(0, ::getrlimit(RLIMIT_FSIZE, &old_limit));
  rlimit limit = old_limit;
  limit.rlim_cur = 1000;
  auto* const old_handler = ::signal(SIGXFSZ, SIG_IGN);
  EXPECT_EQ(0, ::setrlimit(RLIMIT_FSIZE, &limit));
  const std::string error = errorOf(write);
  EXPECT_EQ(0, ::setrlimit(RLIMIT_FSIZE, &old_limit));
  ::signal(SIGXFSZ, old_handler);
  return error;
}

TEST(Files, AFailedWriteKeepsTheOldFileAndLeavesNoOther) {
  const TempDir dir;
  const std::string path = dir.path("map.ot");
  writeFileAtomically(path, "the old map");

  const std::string error =
      errorOnAFullDisk([&] { writeFileAtomically(path, std::string(5000, 'n')); });

  EXPECT_EQ(0U, error.find(path + ": ")) << error;
  EXPECT_EQ("the old map", readRaw(path));
  EXPECT_EQ(std::vector<std::string>{"map.ot"}, dir.files());
}

TEST(Files, AppendedBytesAreWholeOrNotThere) {
  const TempDir dir;
  const std::string path = dir.path("mission.rawlog");
  {
    mrpt::fusion::FileAppender file(path);
    file.append("one");
    file.append("two");
    EXPECT_EQ("onetwo", readRaw(path));
  }
  mrpt::fusion::FileAppender file(path);
  const std::string error = errorOnAFullDisk([&] { file.append(std::string(5000, 'n')); });
  EXPECT_EQ(0U, error.find(path + ": ")) << error;
  EXPECT_EQ("onetwo", readRaw(path));
  file.append("three");
  EXPECT_EQ("onetwothree", readRaw(path));
  EXPECT_THROW(mrpt::fusion::FileAppender(dir.path("none/file")), std::runtime_error);
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

TEST(Files, APipeIsReadToItsEnd) {
  const TempDir dir;
  const std::string pipe = dir.path("pipe");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::string bytes(300'000, 'x');  // more than a pipe holds
  for (size_t i = 0; i < bytes.size(); i += 7) bytes[i] = static_cast<char>(i);
  for (const auto& each : {std::pair(bytes, bytes.size()), std::pair(bytes, size_t{1000}),
                           std::pair(std::string(), size_t{10})}) {
    const std::string& sent = each.first;
    const size_t most = each.second;
    std::thread writer([&] {
      const int fd = ::open(pipe.c_str(), O_WRONLY);
      size_t done = 0;
      while (done < sent.size()) {
        const ssize_t n = ::write(fd, sent.data() + done, sent.size() - done);
        if (n <= 0) break;  // the reader has had enough
        done += static_cast<size_t>(n);
      }
      ::close(fd);
    });
    auto* const old_handler = ::signal(SIGPIPE, SIG_IGN);
    std::string read;
    const std::string error = errorOf([&] { read = readFileBytes(pipe, most); });
    writer.join();
    ::signal(SIGPIPE, old_handler);
    if (sent.size() > most) {
      EXPECT_NE(std::string::npos, error.find("more than 1000 bytes")) << error;
    } else if (sent.empty()) {
      EXPECT_EQ("is empty", error);
    } else {
      EXPECT_EQ("", error);
      EXPECT_TRUE(read == bytes);
    }
  }
}

TEST(Files, ReadFileBytesHasALimit) {
  const TempDir dir;
  writeRaw(dir.path("bytes"), "12345");
  EXPECT_EQ("12345", readFileBytes(dir.path("bytes"), 5));
  EXPECT_EQ("has more than 4 bytes: too many",
            errorOf([&] { readFileBytes(dir.path("bytes"), 4); }));
  if (!std::filesystem::is_character_file("/dev/zero")) GTEST_SKIP() << "/dev/zero is no device";
  EXPECT_EQ("has more than 100000 bytes: too many",
            errorOf([&] { readFileBytes("/dev/zero", 100'000); }));
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

// ---------------------------------------------------------------- what a signal handler does

TEST(RemoveTemporaryFiles, RemovesTheFilesThatAreBeingWritten) {
  const TempDir dir;
  writeFileAtomically(dir.path("done"), "before");
  const auto inner = [&](const mrpt::fusion::ByteSink& sink) {
    sink("b");
    ASSERT_EQ(3U, dir.files().size()) << "two temporary files";
    mrpt::fusion::removeTemporaryFiles();
    EXPECT_EQ(std::vector<std::string>{"done"}, dir.files());
  };
  const auto outer = [&](const mrpt::fusion::ByteSink& sink) {
    sink("a");
    EXPECT_THROW(writeFileAtomically(dir.path("new"), inner), std::runtime_error);
  };
  EXPECT_THROW(writeFileAtomically(dir.path("done"), outer), std::runtime_error)
      << "there is no file to give a name to";
  EXPECT_EQ(std::vector<std::string>{"done"}, dir.files());
  EXPECT_EQ("before", readRaw(dir.path("done")));
}

TEST(RemoveTemporaryFiles, LeavesFilesThatAreDone) {
  const TempDir dir;
  for (int i = 0; i < 100; i++) {  // more than there are places in the list
    writeFileAtomically(dir.path("map"), std::to_string(i));
    EXPECT_THROW(writeFileAtomically(dir.path("map"), [](const auto&) { throw 1; }), int);
  }
  mrpt::fusion::removeTemporaryFiles();
  EXPECT_EQ(std::vector<std::string>{"map"}, dir.files());
  const auto write = [&](const mrpt::fusion::ByteSink&) {
    EXPECT_EQ(2U, dir.files().size());
    mrpt::fusion::removeTemporaryFiles();
    EXPECT_EQ(1U, dir.files().size());
  };
  EXPECT_THROW(writeFileAtomically(dir.path("map"), write), std::runtime_error);
  EXPECT_EQ("99", readRaw(dir.path("map")));
}

TEST(RemoveTemporaryFiles, LeavesFilesAboveTheSizeOfItsList) {
  const TempDir dir;
  std::function<void(int)> write = [&](int depth) {
    writeFileAtomically(dir.path(std::to_string(depth)), [&](const mrpt::fusion::ByteSink&) {
      if (depth > 0) write(depth - 1);
    });
  };
  EXPECT_NO_THROW(write(40));
  EXPECT_EQ(41U, dir.files().size());
}

TEST(RemoveTemporaryFiles, MayBeCalledByASignalHandler) {
  const TempDir dir;
  const auto end_by_signal = [&] {
    ::signal(SIGTERM, [](int) {
      mrpt::fusion::removeTemporaryFiles();
      ::_exit(3);
    });
    writeFileAtomically(dir.path("map"), [](const mrpt::fusion::ByteSink& sink) {
      sink(std::string(100'000, 'x'));
      ::raise(SIGTERM);
    });
  };
  EXPECT_EXIT(end_by_signal(), testing::ExitedWithCode(3), "");
  EXPECT_TRUE(dir.files().empty());
}
