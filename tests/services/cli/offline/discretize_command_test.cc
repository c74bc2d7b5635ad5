// `intaglio discretize` as a person calls it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "services/cli/offline/offline_command.h"
#include "tests/test_folder.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

class DiscretizeCommand : public ::testing::Test {
 protected:
  int Run(std::vector<std::string> arguments) {
    command_line::Program program("intaglio", "");
    AddOfflineCommands(program.root());
    arguments.insert(arguments.begin(), "discretize");
    const std::vector<std::string> common = {"--out", (folder_ / "cloud.ply").string(),
                                             "--materials",
                                             (folder_ / "materials.db").string()};
    arguments.insert(arguments.end(), common.begin(), common.end());
    EXPECT_TRUE(program.Parse(arguments));
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    const int code = program.Run();
    out_ = ::testing::internal::GetCapturedStdout();
    err_ = ::testing::internal::GetCapturedStderr();
    return code;
  }

  const std::string model_ = INTAGLIO_SOURCE_DIR "/deploy/jobs/sample.obj";
  fs::path folder_ = test::FreshFolder();
  std::string out_, err_;
};

TEST_F(DiscretizeCommand, RefusesAGlassThatIsNotInTheBase) {
  EXPECT_EQ(
      Run({"--mesh", model_, "--height", "10", "--spacing", "0.5", "--glass", "BK7X"}),
      2);
  EXPECT_THAT(err_, AllOf(HasSubstr("glass: "), HasSubstr("did you mean N-BK7?")));
  EXPECT_FALSE(fs::exists(folder_ / "cloud.ply"));
  EXPECT_EQ(
      Run({"--mesh", model_, "--height", "10", "--spacing", "0.5", "--glass", "K9"}), 0);
  EXPECT_TRUE(fs::exists(folder_ / "cloud.ply"));
}

TEST_F(DiscretizeCommand, EngravesATextOfTheCommandLine) {
  EXPECT_EQ(Run({"--text", "Anna", "--font", "DejaVu Sans:Bold", "--text-height", "8",
                 "--spacing", "0.3"}),
            0)
      << err_;
  EXPECT_THAT(out_, HasSubstr("points"));
  EXPECT_EQ(Run({"--text", "Anna", "--font", "DejaVoo Sans", "--spacing", "0.3"}), 2);
  EXPECT_THAT(err_, HasSubstr("DejaVu Sans"));
  EXPECT_EQ(Run({"--text", "\U0001F984", "--spacing", "0.3"}), 2);
  EXPECT_THAT(err_, HasSubstr("U+1F984"));
}

TEST_F(DiscretizeCommand, ATextThatIsTooWideIsShrunkOnRequestWithAWarning) {
  const std::vector<std::string> wide = {
      "--text", "Maximiliane-Josephine", "--block", "50", "20", "20", "--spacing", "0.3"};
  EXPECT_EQ(Run(wide), 2);
  EXPECT_THAT(err_, HasSubstr("shrink_to_fit"));
  std::vector<std::string> shrunk = wide;
  shrunk.emplace_back("--shrink-to-fit");
  EXPECT_EQ(Run(shrunk), 0) << err_;
  EXPECT_THAT(err_, HasSubstr("instead of 5 mm"));
}

}  // namespace
}  // namespace intaglio::cli
