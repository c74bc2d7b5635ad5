#include "services/cli/flags/console_flag.h"

#include <gtest/gtest.h>

namespace intaglio::cli {
namespace {

/// The port of a console after these arguments; -1: none.
int PortAfter(const std::vector<std::string>& arguments) {
  command_line::Program program("intaglio", "");
  ConsoleFlags flags;
  AddConsoleFlags(program.root(), flags);
  EXPECT_TRUE(program.Parse(arguments));
  return SettingOf(flags).port;
}

TEST(ConsoleFlag, OpensAConsoleOnlyWhereItIsGiven) {
  EXPECT_EQ(PortAfter({}), -1);
  EXPECT_EQ(PortAfter({"--console"}), 0);
  EXPECT_EQ(PortAfter({"--console=8080"}), 8080);
}

TEST(ConsoleFlag, RefusesWhatIsNoPort) {
  command_line::Program program("intaglio", "");
  ConsoleFlags flags;
  AddConsoleFlags(program.root(), flags);
  for (const char* given : {"--console=70000", "--console=here", "--console=-1"})
    EXPECT_FALSE(program.Parse({given})) << given;
}

TEST(ConsoleFlag, PassesOnWhereItServes) {
  command_line::Program program("intaglio", "");
  ConsoleFlags flags;
  AddConsoleFlags(program.root(), flags);
  ASSERT_TRUE(program.Parse({"--console=8850", "--console-address", "0.0.0.0",
                             "--console-certificate", "shop.pem", "--console-private-key",
                             "shop.key", "--console-users", "people",
                             "--console-webhooks", "hooks"}));
  const client::ConsoleSetting setting = SettingOf(flags);
  EXPECT_EQ(setting.port, 8850);
  EXPECT_EQ(setting.address, "0.0.0.0");
  EXPECT_EQ(setting.certificate, "shop.pem");
  EXPECT_EQ(setting.private_key, "shop.key");
  EXPECT_EQ(setting.users, "people");
  EXPECT_EQ(setting.webhooks, "hooks");
}

TEST(ConsoleFlag, NeedsTheConsoleAndTheKeyOfACertificate) {
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"--console-address", "0.0.0.0"},
        {"--console-webhooks", "hooks"},
        {"--console", "--console-certificate", "shop.pem"},
        {"--console", "--console-private-key", "shop.key"}}) {
    command_line::Program program("intaglio", "");
    ConsoleFlags flags;
    AddConsoleFlags(program.root(), flags);
    EXPECT_FALSE(program.Parse(words)) << words.back();
  }
}

}  // namespace
}  // namespace intaglio::cli
