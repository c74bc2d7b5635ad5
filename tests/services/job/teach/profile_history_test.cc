#include "services/job/teach/profile_history.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <fstream>

#include "services/job/files/job_file.h"
#include "services/job/machine/block_origin.h"
#include "services/job/teach/teaching.h"
#include "tests/services/job/test_job.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

constexpr char kProfile[] = INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto";

fs::path FreshProfile() {
  const fs::path file = test::FreshFolder() / "machine.textproto";
  fs::copy_file(kProfile, file);
  return file;
}

void TeachX(const fs::path& file, double by_mm) {
  const MachineSpec machine = ReadMachineFile(file).value();
  const auto taught = WithZeroMoved(machine, Vec3(by_mm, 0, 0), {1, "f43"});
  ASSERT_TRUE(taught);
  ASSERT_TRUE(SaveTaught(file, *taught, {"2026-01-02T03:04:05Z", "ann@bench", "zero"}));
}

double XOf(const fs::path& file) {
  return BlockOriginOf(ReadMachineFile(file).value(), 1, "f43").x();
}

TEST(ProfileHistory, AChangeIsInTheProfileWithTheNextNumberAndCommentsStay) {
  const fs::path file = FreshProfile();
  const std::string before = test::ContentOf(file);
  TeachX(file, 1.5);
  const std::string after = test::ContentOf(file);
  EXPECT_EQ(after.substr(0, before.size()), before);
  EXPECT_EQ(ReadMachineFile(file)->taught().number(), 1u);
  TeachX(file, 1);
  EXPECT_EQ(ReadMachineFile(file)->taught().number(), 2u);
  EXPECT_EQ(test::ContentOf(file).substr(0, before.size()), before);
  EXPECT_EQ(XOf(file) - Vec3(ReadMachineFile(kProfile)->block_origin_mm().x(), 0, 0).x(),
            2.5);
}

TEST(ProfileHistory, CommentsStayInAProfileThatHadAByteOrderMark) {
  const fs::path file = FreshProfile();
  const std::string before = test::ContentOf(file);
  std::ofstream(file, std::ios::binary) << "\xEF\xBB\xBF" << before;
  TeachX(file, 1.5);
  EXPECT_EQ(test::ContentOf(file).substr(0, before.size()), before);
  EXPECT_EQ(ReadMachineFile(file)->taught().number(), 1u);
}

TEST(ProfileHistory, UndoGoesBackStepByStepToTheProfileAsItWas) {
  const fs::path file = FreshProfile();
  const double first = XOf(file);
  TeachX(file, 1);
  TeachX(file, 2);
  TeachX(file, 4);
  EXPECT_EQ(XOf(file), first + 7);
  const auto undone = UndoTaught(file, {"2026-01-02T04:00:00Z", "bob@bench", ""});
  ASSERT_TRUE(undone);
  EXPECT_EQ(undone->taught().number(), 4u);
  EXPECT_THAT(undone->change(), HasSubstr("undo of 3"));
  EXPECT_EQ(XOf(file), first + 3);
  ASSERT_TRUE(UndoTaught(file, {}));
  EXPECT_EQ(XOf(file), first + 1);
  // A change after an undo is undone to what it changed.
  TeachX(file, 8);
  EXPECT_EQ(XOf(file), first + 9);
  ASSERT_TRUE(UndoTaught(file, {}));
  EXPECT_EQ(XOf(file), first + 1);
  ASSERT_TRUE(UndoTaught(file, {}));
  EXPECT_EQ(XOf(file), first);
  EXPECT_FALSE(ReadMachineFile(file)->taught().zeros_size() > 0);
  const auto nothing = UndoTaught(file, {});
  ASSERT_FALSE(nothing);
  EXPECT_EQ(nothing.error().code, ErrorCode::kNotFound);
  const auto history = TaughtHistory(file);
  ASSERT_TRUE(history);
  ASSERT_EQ(history->size(), 9u);
  EXPECT_EQ(history->front().change(), "as found in the profile");
  EXPECT_EQ((*history)[1].taught_by(), "ann@bench");
}

// A person who goes back twice has to read that the second change is gone as well.
TEST(ProfileHistory, EachUndoNamesTheChangeThatItTakesBack) {
  const fs::path file = FreshProfile();
  const auto teach = [&file](const char* change) {
    const auto taught = ReadMachineFile(file)->taught();
    ASSERT_TRUE(SaveTaught(file, taught, {"2026-01-02T03:04:05Z", "ann@bench", change}));
  };
  teach("zero");
  teach("soft limits");
  teach("park position");
  EXPECT_EQ(UndoTaught(file, {})->change(), "undo of 3: park position");
  EXPECT_EQ(UndoTaught(file, {})->change(), "undo of 2: soft limits");
  teach("sample position");
  EXPECT_EQ(UndoTaught(file, {})->change(), "undo of 6: sample position");
  EXPECT_EQ(UndoTaught(file, {})->change(), "undo of 1: zero");
}

// Killed after the version and before the profile: the profile is the truth.
TEST(ProfileHistory, AVersionWithoutItsProfileIsWrittenOver) {
  const fs::path file = FreshProfile();
  TeachX(file, 1);
  const std::string old = test::ContentOf(file);
  const double x = XOf(file);
  TeachX(file, 2);
  { std::ofstream(file, std::ios::trunc) << old; }
  EXPECT_EQ(TaughtHistory(file)->size(), 2u);
  TeachX(file, 4);
  EXPECT_EQ(XOf(file), x + 4);
  EXPECT_EQ(TaughtHistory(file)->back().taught().number(), 2u);
}

TEST(ProfileHistory, AProfileThatWasEditedByHandIsKeptBeforeTheNextChange) {
  const fs::path file = FreshProfile();
  TeachX(file, 1);
  MachineSpec edited = ReadMachineFile(file).value();
  edited.mutable_taught()->mutable_zeros(0)->mutable_block_origin_mm()->set_x(50);
  ASSERT_TRUE(WriteMachineFile(file, edited));
  TeachX(file, 1);
  EXPECT_EQ(XOf(file), 51);
  ASSERT_TRUE(UndoTaught(file, {}));
  EXPECT_EQ(XOf(file), 50);
}

TEST(ProfileHistory, OnlyTheFieldOfTheOutermostMessageIsReplaced) {
  TaughtPositions taught;
  taught.set_number(3);
  const std::string text =
      "name: \"taught { }\"  # taught { number: 9 }\n"
      "taught: < number: 1 zeros { lens: \"}\" } >\n"
      "block_origin_mm { x: 1 }\n"
      "taught {\n  number: 2 # }\n}\n";
  EXPECT_EQ(WithTaught(text, taught),
            "name: \"taught { }\"  # taught { number: 9 }\n"
            "block_origin_mm { x: 1 }\n"
            "taught {\n  number: 3\n}\n");
  EXPECT_EQ(WithTaught("name: \"a\"", taught), "name: \"a\"\ntaught {\n  number: 3\n}\n");
}

// As under systemd, where the mask lets nobody else read what a service writes.
TEST(ProfileHistory, WhoMayReadTheProfileMayReadItAfterwards) {
  const fs::path file = FreshProfile();
  const auto wanted = fs::perms::owner_read | fs::perms::owner_write |
                      fs::perms::group_read | fs::perms::others_read;
  fs::permissions(file, wanted);
  const mode_t before = umask(0077);
  const auto saved = SaveTaught(file, {}, {});
  umask(before);
  ASSERT_TRUE(saved) << saved.error().message;
  EXPECT_EQ(fs::status(file).permissions(), wanted);
}

TEST(ProfileHistory, AFolderThatCannotBeWrittenChangesNothing) {
  const fs::path file = FreshProfile();
  std::ofstream(HistoryFolderOf(file)) << "a file in its place";
  const std::string before = test::ContentOf(file);
  const auto saved = SaveTaught(file, {}, {});
  ASSERT_FALSE(saved);
  EXPECT_EQ(saved.error().code, ErrorCode::kIo);
  EXPECT_EQ(test::ContentOf(file), before);
}

}  // namespace
}  // namespace intaglio
