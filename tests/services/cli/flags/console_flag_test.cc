#include "services/cli/flags/console_flag.h"

#include <gtest/gtest.h>

namespace intaglio::cli {
namespace {

/// The port of a console after these arguments; -1: none.
int PortAfter(const std::vector<std::string>& arguments) {
  command_line::Program program("intaglio", "");
  std::string port;
  AddConsoleFlag(program.root(), port);
  EXPECT_TRUE(program.Parse(arguments));
  return ConsolePortOf(port);
}

TEST(ConsoleFlag, OpensAConsoleOnlyWhereItIsGiven) {
  EXPECT_EQ(PortAfter({}), -1);
  EXPECT_EQ(PortAfter({"--console"}), 0);
  EXPECT_EQ(PortAfter({"--console=8080"}), 8080);
}

TEST(ConsoleFlag, RefusesWhatIsNoPort) {
  command_line::Program program("intaglio", "");
  std::string port;
  AddConsoleFlag(program.root(), port);
  for (const char* given : {"--console=70000", "--console=here", "--console=-1"})
    EXPECT_FALSE(program.Parse({given})) << given;
}

}  // namespace
}  // namespace intaglio::cli
