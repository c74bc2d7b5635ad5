#pragma once

// A command of intaglio as a person types it, in the test's own process.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "services/cli/intaglio_program.h"
#include "services/client/exit_codes.h"
#include "services/platform/command_line/program.h"
#include "tests/test_folder.h"

namespace intaglio::cli {

class TypedCommand : public ::testing::Test {
 protected:
  /// `add` adds the commands to the program. The exit code; output_ and errors_ are those
  /// of this command.
  template <typename Add>
  int TypeTo(Add add, const std::vector<std::string>& words) {
    command_line::Program program("intaglio", "");
    add(program.root());
    const auto parsed = program.Parse(words);
    EXPECT_TRUE(parsed) << (parsed ? "" : parsed.error().message);
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    const int code = program.Run();
    output_ = ::testing::internal::GetCapturedStdout();
    errors_ = ::testing::internal::GetCapturedStderr();
    return code;
  }

  /// The same of the whole program. Words that it does not understand are wrong input, as
  /// for a person: 2, and the error in errors_.
  int TypeToAll(const std::vector<std::string>& words) {
    const auto program = IntaglioProgram();
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    const auto parsed = program->Parse(words);
    const int code = parsed ? program->Run() : client::kExitWrongInput;
    output_ = ::testing::internal::GetCapturedStdout();
    errors_ = ::testing::internal::GetCapturedStderr();
    if (!parsed) errors_ += parsed.error().message;
    return code;
  }

  std::filesystem::path folder_ = test::FreshFolder();
  std::string output_, errors_;
};

}  // namespace intaglio::cli
