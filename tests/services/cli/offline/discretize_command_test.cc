// `intaglio discretize` as a person calls it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

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

TEST_F(DiscretizeCommand, OnlyTheAskedModelsAreWritten) {
  for (const char* name : {"one.xyz", "two.xyz"}) {
    std::ofstream(folder_ / name)
        << (name[0] == 'o' ? "5 5 5\n5 5 6\n" : "5 5 5\n9 9 9\n");
  }
  const std::vector<std::string> both = {"--mesh",    (folder_ / "one.xyz").string(),
                                         "--mesh",    (folder_ / "two.xyz").string(),
                                         "--block",   "20",
                                         "20",        "20",
                                         "--spacing", "0.5"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), both.begin(), both.end());
    return more;
  };
  EXPECT_EQ(Run(both), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("3 points"));
  // The shared place is the first model's, as in the whole.
  EXPECT_EQ(Run(with({"--only", "2"})), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("1 point,"));
  EXPECT_EQ(Run(with({"--only", "1", "2"})), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("3 points"));
  EXPECT_EQ(Run(with({"--only", "3"})), 2);
  EXPECT_THAT(err_, HasSubstr("--only: there is no model 3; the job has models 1 to 2"));
}

TEST_F(DiscretizeCommand, AnyFieldIsSetByItsPath) {
  std::ofstream(folder_ / "points.xyz") << "5 5 5\n5 5 6\n";
  const std::vector<std::string> points = {
      "--mesh", (folder_ / "points.xyz").string(), "--block", "20", "20", "20"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), points.begin(), points.end());
    return more;
  };
  EXPECT_EQ(Run(with({"--set", "models[0].copies.count_x=3", "--set",
                      "models[0].copies.step_mm=2 0 0"})),
            0)
      << err_;
  EXPECT_THAT(out_, HasSubstr("6 points"));
  EXPECT_EQ(Run(with({"--set", "block.margin=3"})), 2);
  EXPECT_THAT(err_, HasSubstr("--set: block.margin: Block has no field 'margin'; it has: "
                              "size_mm, margin_mm, clip"));
  EXPECT_EQ(Run(with({"--set", "block.margin_mm"})), 2);
  EXPECT_THAT(err_, HasSubstr("has no =; write it as block.margin_mm=5"));
  EXPECT_EQ(Run(with({"--set", "block.margin_mm=900"})), 2);
  EXPECT_THAT(err_, HasSubstr("block.margin_mm"));
}

}  // namespace
}  // namespace intaglio::cli
