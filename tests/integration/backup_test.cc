// Backup and restore of a real shop, and a damaged queue as its people see it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <fstream>
#include <map>
#include <memory>

#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using ::testing::ContainsRegex;
using testing::Ended;
using testing::Eventually;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::Program;
using testing::Running;

class KeptShop : public ::testing::Test {
 protected:
  std::unique_ptr<Running> Up(const std::string& shop) {
    auto up = std::make_unique<Running>(
        Program("intaglio"),
        OnBus({"up", "--folder", folder_ / shop, "--materials", Materials(), "--lockstep",
               "--block", "50", "50", "30"}),
        folder_ / (shop + ".txt"));
    EXPECT_TRUE(Eventually(
        [&] {
          return !up->running() ||
                 up->Output().find("the shop is open") != std::string::npos;
        },
        30s));
    return up;
  }
  static void Close(Running& up) {
    up.Signal(SIGINT);
    const Ended ended = up.WaitForEnd(15s);
    EXPECT_EQ(ended.exit_code, 0) << ended.output;
  }
  std::string Materials() const { return folder_ / "materials.db"; }
  static std::vector<std::string> OnBus(std::vector<std::string> words) {
    for (const std::string& word :
         {std::string("--domain"), std::string("44"), std::string("--tag"),
          "kept" + std::to_string(getpid())}) {
      words.push_back(word);
    }
    return words;
  }
  Ended Type(const std::vector<std::string>& words) {
    Running run(Program("intaglio"), words,
                folder_ / ("typed" + std::to_string(++typed_) + ".txt"));
    return run.WaitForEnd(60s);
  }
  void Submit(int count) {
    for (int i = 0; i < count; ++i) {
      const Ended ended = Type(OnBus(
          {"submit", std::string(INTAGLIO_SOURCE_DIR) + "/deploy/jobs/sample.textproto",
           "--height", "6"}));
      ASSERT_EQ(ended.exit_code, 0) << ended.output;
    }
  }
  Ended Restore(const std::string& shop, std::vector<std::string> more = {}) {
    std::vector<std::string> words = {"restore",     folder_ / "one.backup",
                                      "--folder",    folder_ / shop,
                                      "--materials", folder_ / (shop + "-materials.db")};
    words.insert(words.end(), more.begin(), more.end());
    return Type(words);
  }

  fs::path folder_ = test::FreshFolder();
  int typed_ = 0;
};

TEST_F(KeptShop, IsBackedUpOpenAndRestoredClosed) {
  {
    const auto up = Up("shop");
    Submit(3);
    const Ended made = Type({"backup", folder_ / "one.backup", "--folder",
                             folder_ / "shop", "--materials", Materials()});
    EXPECT_EQ(made.exit_code, 0) << made.output;
    for (const char* part : {"queue", "jobs", "materials", "machines"})
      EXPECT_THAT(made.output, HasSubstr(part));
    Submit(1);
    const Ended refused = Restore("shop", {"--replace"});
    EXPECT_EQ(refused.exit_code, 2) << refused.output;
    EXPECT_THAT(refused.output, HasSubstr("is in use by the process"));
    // Without its folder, by the queue itself.
    const Ended by_queue =
        Restore("shop", {"--replace", "--database", folder_ / "shop" / "jobs.db"});
    EXPECT_EQ(by_queue.exit_code, 2) << by_queue.output;
    EXPECT_THAT(by_queue.output, HasSubstr("close that shop"));
    EXPECT_THAT(Type(OnBus({"list"})).output, ContainsRegex("\n *4  "));
    Close(*up);
  }
  const Ended listed = Restore("shop", {"--list"});
  EXPECT_EQ(listed.exit_code, 0) << listed.output;
  EXPECT_THAT(listed.output, HasSubstr("queue/jobs.db"));
  EXPECT_THAT(listed.output, HasSubstr("machines/machine.textproto"));
  const Ended there = Restore("shop");
  EXPECT_EQ(there.exit_code, 2) << there.output;
  EXPECT_THAT(there.output, HasSubstr("--replace"));
  // Elsewhere, and the shop opens with the three jobs of then.
  const Ended restored = Restore("second");
  ASSERT_EQ(restored.exit_code, 0) << restored.output;
  const auto up = Up("second");
  const Ended list = Type(OnBus({"list"}));
  EXPECT_EQ(list.exit_code, 0) << list.output;
  EXPECT_THAT(list.output, ContainsRegex("\n *3  "));
  EXPECT_THAT(list.output, Not(ContainsRegex("\n *4  ")));
  Close(*up);
}

TEST_F(KeptShop, ADamagedQueueIsReportedAndRestored) {
  {
    const auto up = Up("shop");
    Submit(2);
    Close(*up);
  }
  ASSERT_EQ(Type({"backup", folder_ / "one.backup", "--folder", folder_ / "shop",
                  "--materials", Materials()})
                .exit_code,
            0);
  const fs::path queue = folder_ / "shop" / "jobs.db";
  const auto pages = fs::file_size(queue) / 4096;
  for (std::uintmax_t page = 2; page < pages; ++page) {
    std::fstream(queue, std::ios::in | std::ios::out | std::ios::binary)
        .seekp(static_cast<std::streamoff>(page * 4096))
        .write(std::string(4096, 'x').data(), 4096);
  }
  for (const Ended& ended :
       {Type(OnBus({"up", "--folder", folder_ / "shop", "--materials", Materials()})),
        Type({"history", "--folder", folder_ / "shop"}),
        Type({"backup", folder_ / "two.backup", "--folder", folder_ / "shop"})}) {
    EXPECT_EQ(ended.exit_code, 2) << ended.output;
    EXPECT_THAT(ended.output, HasSubstr("the queue " + queue.string() + " is damaged"));
    EXPECT_THAT(ended.output, HasSubstr("intaglio restore"));
  }
  const Ended restored = Restore("shop", {"--replace"});
  ASSERT_EQ(restored.exit_code, 0) << restored.output;
  EXPECT_THAT(restored.output, HasSubstr("kept "));
  const auto up = Up("shop");
  EXPECT_THAT(Type(OnBus({"list"})).output, ContainsRegex("\n *2  "));
  Close(*up);
}

// A backup that was cut changes nothing, and no folder is made.
TEST_F(KeptShop, ACutBackupIsRefusedByName) {
  {
    const auto up = Up("shop");
    Submit(1);
    Close(*up);
  }
  const fs::path file = folder_ / "one.backup";
  ASSERT_EQ(
      Type({"backup", file, "--folder", folder_ / "shop", "--materials", Materials()})
          .exit_code,
      0);
  fs::resize_file(file, fs::file_size(file) * 2 / 3);
  const Ended refused = Restore("second");
  EXPECT_EQ(refused.exit_code, 2) << refused.output;
  EXPECT_THAT(refused.output, HasSubstr("the backup " + file.string() + " is damaged"));
  EXPECT_FALSE(fs::exists(folder_ / "second"));
  EXPECT_FALSE(fs::exists(folder_ / "second-materials.db"));
}

}  // namespace
}  // namespace intaglio
