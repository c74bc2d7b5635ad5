#include "services/platform/command_line/standard_streams.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "tests/test_folder.h"

namespace intaglio::command_line {
namespace {

namespace fs = std::filesystem;

/// What a program does whose standard output is closed: it keeps a file open and prints.
int PrintWithout(int stream, const fs::path& file) {
  close(stream);
  KeepStandardStreams();
  std::ofstream kept(file);
  kept << "kept" << std::flush;
  std::printf("printed\n");
  return FlushOutput() ? 0 : 2;
}

TEST(StandardStreams, WhatIsPrintedToAClosedOutputGetsIntoNoFile) {
  const fs::path file = test::FreshFolder() / "lock";
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) _exit(PrintWithout(STDOUT_FILENO, file));
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 2) << "what was printed is lost";
  EXPECT_EQ(fs::file_size(file), 4u);
}

TEST(StandardStreams, AnOpenOutputIsWhole) { EXPECT_TRUE(FlushOutput()); }

}  // namespace
}  // namespace intaglio::command_line
