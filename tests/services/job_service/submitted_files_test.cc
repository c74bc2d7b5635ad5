// A submission names the file of its machine: the real process reads it with bounds,
// whatever it is, and its permissions go on meanwhile.

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <fstream>

#include "tests/services/job/test_job.h"
#include "tests/services/job_service/fake_shop.h"
#include "tests/test_folder.h"

namespace intaglio::job_service {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;

class SubmittedFiles : public testing::Test {
 protected:
  SubmittedFiles()
      : folder_(test::FreshFolder()), service_(folder_, test::PrivateTag()) {}

  fs::path Path(const std::string& name) const { return folder_ / (name + ".textproto"); }
  /// What a job for the machine in this file is answered.
  std::string AnswerTo(const fs::path& machine_file) {
    JobSpec job = GoodJob();
    job.set_machine_file(machine_file);
    const std::string uid = machine_file.filename();
    shop_.Submit(uid, job);
    EXPECT_TRUE(shop_.Until([&] { return !shop_.Status(uid).message.empty(); })) << uid;
    EXPECT_EQ(shop_.Status(uid).state, intaglio_JOB_FAILED);
    EXPECT_EQ(shop_.Status(uid).uid, "");
    return shop_.Status(uid).message;
  }

  fs::path folder_;
  FakeShop shop_{test::PrivateBusOptions()};
  ServiceProcess service_;
};

TEST_F(SubmittedFiles, AreFilesAndNothingElse) {
  // A cell whose permission is watched meanwhile.
  shop_.Submit("good", GoodJob());
  ASSERT_TRUE(shop_.Until([&] { return shop_.permissions_seen() > 3; }));

  ASSERT_EQ(mkfifo(Path("fifo").c_str(), 0600), 0);
  fs::create_symlink("/dev/zero", Path("zero"));
  fs::create_directory(Path("folder"));
  std::ofstream(Path("huge")) << "name: 'x'";
  fs::resize_file(Path("huge"), std::uintmax_t{8} << 30);
  fs::create_symlink(Path("loop"), Path("loop"));
  for (const char* name : {"fifo", "zero", "folder"}) {
    EXPECT_THAT(AnswerTo(Path(name)),
                AllOf(HasSubstr("machine_file: "), HasSubstr(Path(name).string()),
                      HasSubstr("this is not a file")));
  }
  EXPECT_THAT(AnswerTo(Path("huge")),
              AllOf(HasSubstr(Path("huge").string()), HasSubstr("8589934592 bytes")));
  EXPECT_THAT(AnswerTo(Path("loop")), HasSubstr(Path("loop").string()));
  EXPECT_THAT(AnswerTo(Path("absent")), HasSubstr("the file does not exist"));

  const int before = shop_.permissions_seen();
  EXPECT_TRUE(shop_.Until([&] { return shop_.permissions_seen() > before + 3; }));
  EXPECT_EQ(service_.Stop(), 0) << "no thread is left that waits";
}

TEST_F(SubmittedFiles, JobsAreNumberedAsTheyWereSubmitted) {
  for (int i = 1; i <= 9; ++i) shop_.Submit("s" + std::to_string(i), GoodJob());
  for (int i = 1; i <= 9; ++i) {
    const std::string uid = "s" + std::to_string(i);
    ASSERT_TRUE(shop_.Until([&] { return !shop_.Status(uid).uid.empty(); })) << uid;
    EXPECT_THAT(shop_.Status(uid).uid, testing::StartsWith(std::to_string(i) + "-"));
  }
}

}  // namespace
}  // namespace intaglio::job_service
