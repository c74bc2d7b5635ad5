#include "services/platform/command_line/supplied_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "services/platform/command_line/other_programs.h"
#include "tests/test_folder.h"

namespace intaglio::command_line {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class Supplied : public ::testing::Test {
 protected:
  void SetUp() override { unsetenv(kSuppliedVariable); }
  void TearDown() override { unsetenv(kSuppliedVariable); }
  fs::path Write(const fs::path& file) const {
    fs::create_directories((folder_ / file).parent_path());
    std::ofstream(folder_ / file) << "name: \"x\"\n";
    return folder_ / file;
  }
  fs::path folder_ = test::FreshFolder();
};

// Test programs lie beside bin/ of the build tree, as deep as the programs do.
TEST_F(Supplied, FilesAreFoundByThePlaceOfTheProgram) {
  EXPECT_EQ(SuppliedFolder(), ProgramFolder().parent_path() / "share/intaglio");
  const auto profile = FindSupplied("els-03", kSuppliedProfiles);
  ASSERT_TRUE(profile) << profile.error().message;
  EXPECT_TRUE(
      fs::equivalent(*profile, INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto"));
  const auto job = FindSupplied("sample", kSuppliedJobs);
  ASSERT_TRUE(job) << job.error().message;
  EXPECT_TRUE(fs::equivalent(*job, INTAGLIO_SOURCE_DIR "/deploy/jobs/sample.textproto"));
}

TEST_F(Supplied, TheEnvironmentNamesAnotherFolder) {
  const fs::path own = Write("machines/own.textproto");
  setenv(kSuppliedVariable, folder_.c_str(), 1);
  EXPECT_EQ(SuppliedFolder(), folder_);
  const auto found = FindSupplied("own", kSuppliedProfiles);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(*found, fs::canonical(own));
  EXPECT_FALSE(FindSupplied("els-03", kSuppliedProfiles));
  setenv(kSuppliedVariable, "", 1);
  EXPECT_TRUE(FindSupplied("els-03", kSuppliedProfiles));
}

TEST_F(Supplied, AFileOfThisNamePrecedes) {
  const fs::path file = Write("els-03");
  const auto found = FindSupplied(file.string(), kSuppliedProfiles);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(*found, file);
}

TEST_F(Supplied, UnknownNameListsTheSuppliedOnes) {
  Write("machines/left.textproto");
  Write("machines/and.json");
  Write("machines/README.md");
  setenv(kSuppliedVariable, folder_.c_str(), 1);
  const auto found = FindSupplied("lefft", kSuppliedProfiles);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(found.error().message,
            "'lefft' is neither a file nor a supplied profile; did you mean left?; "
            "supplied profiles: and, left");
}

TEST_F(Supplied, MissingFolderIsNamedWithItsRemedy) {
  setenv(kSuppliedVariable, (folder_ / "gone").c_str(), 1);
  const auto found = FindSupplied("els-03", kSuppliedProfiles);
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().message, HasSubstr((folder_ / "gone/machines").string()));
  EXPECT_THAT(found.error().message, HasSubstr(kSuppliedVariable));
}

}  // namespace
}  // namespace intaglio::command_line
