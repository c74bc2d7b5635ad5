// The foreman's day at the command line: a shop that is refused, a full disk, emergency
// stops, a shop that is closed and opened again; what is printed, and the exit codes.

#include <gmock/gmock.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <fstream>
#include <map>
#include <memory>
#include <regex>
#include <sstream>

#include "proto/shop.pb.h"
#include "tests/engrave/io/small_disk.h"
#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::Ended;
using testing::Eventually;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::Program;
using testing::Running;

std::map<std::string, std::string> ContentsOf(const fs::path& folder) {
  std::map<std::string, std::string> contents;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    std::stringstream bytes;
    if (entry.is_regular_file()) bytes << std::ifstream(entry.path()).rdbuf();
    contents[entry.path().string()] = bytes.str();
  }
  return contents;
}

class Foreman : public ::testing::Test {
 protected:
  std::vector<std::string> With(std::vector<std::string> words) const {
    for (const std::string& word :
         {std::string("--domain"), std::string("46"), std::string("--tag"),
          "foreman" + std::to_string(getpid())}) {
      words.push_back(word);
    }
    return words;
  }
  std::vector<std::string> Up(const fs::path& folder) const {
    return With({"up", "--folder", folder, "--materials", disk_ / "materials" / "base.db",
                 "--speed", "5", "--warm-up", "5", "--block", "50", "50", "30"});
  }
  Ended Run(const std::vector<std::string>& words) {
    Running run(Program("intaglio"), words,
                folder_ / ("typed" + std::to_string(++typed_) + ".txt"));
    return run.WaitForEnd(60s);
  }
  Ended Type(const std::vector<std::string>& words) { return Run(With(words)); }
  void Open() {
    up_ = std::make_unique<Running>(Program("intaglio"), Up(shop_), folder_ / "up.txt");
    ASSERT_TRUE(Eventually(
        [this] { return up_->Output().find("the shop is open") != std::string::npos; },
        60s))
        << up_->Output();
  }
  void Close() {
    up_->Signal(SIGINT);
    const Ended ended = up_->WaitForEnd(20s);
    EXPECT_TRUE(ended.in_time);
    EXPECT_EQ(ended.exit_code, 0) << ended.output;
  }
  static std::vector<std::string> SampleJob() {
    return {"submit",   INTAGLIO_SOURCE_DIR "/deploy/jobs/sample.textproto",
            "--height", "6",
            "--rate",   "10"};
  }
  /// The newest `status` has this text.
  bool Shows(const std::vector<std::string>& words, const std::string& text) {
    return Eventually(
        [&] {
          last_ = Type(words);
          return last_.output.find(text) != std::string::npos;
        },
        60s);
  }
  /// A busy host may pause it; the operator then does what the message asks for.
  bool RunsTo(const std::string& state) {
    return Eventually(
        [&] {
          last_ = Type({"show", "1"});
          if (last_.output.find("state      " + state) != std::string::npos) return true;
          if (last_.output.find("state      paused") != std::string::npos)
            Type({"resume", "1"});
          return false;
        },
        90s);
  }
  void FillTheDisk() const {
    std::ofstream out(disk_ / "full", std::ios::binary | std::ios::app);
    const std::string block(1 << 16, 'x');
    while (out.write(block.data(), static_cast<std::streamsize>(block.size())).flush()) {
    }
    std::ofstream rest(disk_ / "full2", std::ios::binary | std::ios::app);
    while (rest.put('x').flush()) {
    }
  }
  void MakeRoom() const {
    fs::remove(disk_ / "full");
    fs::remove(disk_ / "full2");
  }

  fs::path folder_ = test::FreshFolder(), disk_ = folder_ / "disk",
           shop_ = disk_ / "shop";
  std::unique_ptr<Running> up_;
  Ended last_;
  int typed_ = 0;
};

TEST_F(Foreman, PlaysTheDay) {
  fs::create_directory(disk_);
  if (!io::MountSmallDisk(disk_, 140 << 20))
    GTEST_SKIP() << "a small file system needs root";

  // Morning: somebody has filled the disk.
  FillTheDisk();
  const Ended full = Run(Up(shop_));
  EXPECT_EQ(full.exit_code, 4) << full.output;
  EXPECT_THAT(full.output, HasSubstr("is full"));
  EXPECT_THAT(full.output, HasSubstr(shop_.string()));
  EXPECT_FALSE(fs::exists(shop_));
  MakeRoom();
  ASSERT_NO_FATAL_FAILURE(Open());
  ASSERT_TRUE(Shows({"status"}, "all is well")) << last_.output;
  EXPECT_EQ(last_.exit_code, 0);
  EXPECT_THAT(last_.output, HasSubstr("els-03"));
  EXPECT_THAT(last_.output, HasSubstr("key on, door closed, stop released"));

  // A job waits for its arm.
  const Ended submitted = Type(SampleJob());
  EXPECT_EQ(submitted.exit_code, 0) << submitted.output;
  ASSERT_TRUE(Shows({"status"}, "job 1 waits for its arm")) << last_.output;
  EXPECT_EQ(last_.exit_code, 4);
  EXPECT_EQ(Type({"arm", "1"}).exit_code, 0);
  ASSERT_TRUE(RunsTo("engraving")) << last_.output;

  // The disk is full in the middle of it.
  FillTheDisk();
  const Ended refused = Type(SampleJob());
  EXPECT_EQ(refused.exit_code, 4) << refused.output;
  EXPECT_THAT(refused.output, HasSubstr("jobs.db"));
  EXPECT_THAT(refused.output, HasSubstr("free space on its disk"));
  EXPECT_THAT(refused.output, Not(HasSubstr("no job service")));
  const Ended listed = Type({"list"});
  EXPECT_EQ(listed.exit_code, 4) << listed.output;
  EXPECT_THAT(listed.output, HasSubstr("trefoil knot"));
  EXPECT_THAT(listed.output, HasSubstr("the job service cannot work"));
  EXPECT_THAT(listed.output, HasSubstr("jobs.db"));
  const Ended shown = Type({"show", "1"});
  EXPECT_EQ(shown.exit_code, 4) << shown.output;
  EXPECT_THAT(shown.output, HasSubstr("state      paused"));
  EXPECT_THAT(shown.output, HasSubstr("the job service cannot work"));
  const Ended resumed_full = Type({"resume", "1"});
  EXPECT_EQ(resumed_full.exit_code, 4) << resumed_full.output;
  EXPECT_THAT(resumed_full.output, HasSubstr("jobs.db"));
  const Ended status = Type({"status"});
  EXPECT_EQ(status.exit_code, 4);
  EXPECT_THAT(status.output, HasSubstr("NEARLY FULL"));
  EXPECT_THAT(status.output, HasSubstr("job-service: job database"));
  MakeRoom();
  ASSERT_TRUE(Eventually([this] { return Type({"list"}).exit_code == 0; }, 40s));
  EXPECT_THAT(Type({"list"}).output, Not(::testing::ContainsRegex("\n *2  ")))
      << "the job that was refused is not taken afterwards";
  ASSERT_TRUE(RunsTo("engraving")) << last_.output;

  // An emergency stop from the office, and a door that is open when it is reset.
  EXPECT_EQ(Type({"stop", "--reason", "a hand in the machine"}).exit_code, 0);
  ASSERT_TRUE(Shows({"show", "1"}, "state      paused")) << last_.output;
  const Ended resumed = Type({"resume", "1"});
  EXPECT_EQ(resumed.exit_code, 4);
  EXPECT_THAT(resumed.output, HasSubstr("stop_pressed"));
  EXPECT_THAT(resumed.output, HasSubstr("intaglio stop els-03 --reset"));
  ASSERT_TRUE(Shows({"status"}, "STOP PRESSED by intaglio-stop-")) << last_.output;
  EXPECT_EQ(last_.exit_code, 4);
  testing::AskPanel(shop_, "door open");
  ASSERT_TRUE(Shows({"status"}, "DOOR OPEN")) << last_.output;
  const Ended held = Type({"stop", "els-03", "--reset"});
  EXPECT_EQ(held.exit_code, 4) << held.output;
  EXPECT_THAT(held.output, HasSubstr("the stop is reset"));
  EXPECT_THAT(held.output, HasSubstr("the door is open"));
  testing::AskPanel(shop_, "door close");
  ASSERT_TRUE(Shows({"status"}, "door closed")) << last_.output;
  const Ended reset = Type({"stop", "els-03", "--reset"});
  EXPECT_EQ(reset.exit_code, 0) << reset.output;
  EXPECT_THAT(reset.output, HasSubstr("els-03: reset"));
  ASSERT_TRUE(RunsTo("engraving")) << last_.output;

  // The button of the machine, which the job service does not know of.
  testing::AskPanel(shop_, "estop press");
  ASSERT_TRUE(Shows({"show", "1"}, "state      paused")) << last_.output;
  const Ended pressed = Type({"resume", "1"});
  EXPECT_EQ(pressed.exit_code, 4) << pressed.output;
  EXPECT_THAT(pressed.output, HasSubstr("emergency stop is pressed"));
  testing::AskPanel(shop_, "estop release");
  ASSERT_TRUE(RunsTo("engraving")) << last_.output;

  // Evening and morning.
  Close();
  const Ended closed = Type({"list"});
  EXPECT_EQ(closed.exit_code, 2);
  EXPECT_THAT(closed.output, HasSubstr("no services found"));
  EXPECT_EQ(Type({"status"}).exit_code, 2);
  ASSERT_NO_FATAL_FAILURE(Open());
  ASSERT_TRUE(Shows({"list"}, "1  paused ")) << last_.output;
  EXPECT_EQ(last_.exit_code, 0);
  EXPECT_THAT(last_.output, HasSubstr("that the right block or piece is in the machine"));
  ASSERT_TRUE(Shows({"status"}, "job 1 is paused")) << last_.output;
  EXPECT_EQ(last_.exit_code, 4);
  ASSERT_TRUE(RunsTo("done")) << last_.output;
  EXPECT_THAT(last_.output, HasSubstr("verdict    good"));
  EXPECT_THAT(last_.output, ::testing::ContainsRegex(
                                "points     [0-9 ]+ planned, [0-9 ]+ made, 0 missed"));
  const Ended list = Type({"list"});
  EXPECT_EQ(list.exit_code, 0);
  EXPECT_THAT(list.output, ::testing::ContainsRegex("done .* good .* made [0-9 ]+ / "));

  // For programs.
  Running asked(Program("intaglio"), With({"status", "--json"}), folder_ / "status.json");
  EXPECT_EQ(asked.WaitForEnd(30s).exit_code, 0) << asked.Output();
  ShopStatus parsed;
  ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(asked.Output(), &parsed).ok())
      << asked.Output();
  EXPECT_FALSE(parsed.needs_person());
  ASSERT_EQ(parsed.machines_size(), 1);
  EXPECT_TRUE(parsed.machines(0).door_closed());
  EXPECT_EQ(parsed.ended_jobs(), 1u);
  ASSERT_EQ(parsed.disks_size(), 1);
  EXPECT_NEAR(parsed.disks(0).total_bytes(), 140 << 20, 1 << 20);
  Close();
}

// ---- A shop that is refused ----------------------------------------------------------

TEST_F(Foreman, AShopThatIsRefusedLeavesNothingBehind) {
  fs::create_directory(disk_);
  const auto refuse = [&](const std::vector<std::string>& words, const std::string& why) {
    const auto before = ContentsOf(disk_);
    const Ended refused = Run(words);
    EXPECT_EQ(refused.exit_code, 2) << refused.output;
    EXPECT_THAT(refused.output, HasSubstr(why));
    EXPECT_EQ(ContentsOf(disk_), before) << why;
    EXPECT_THAT(testing::ProcessesWith({(disk_ / "deep").string()}),
                ::testing::IsEmpty());
  };
  const fs::path deep = disk_ / "deep" / "shop";
  const auto with = [](std::vector<std::string> words,
                       const std::vector<std::string>& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
  };
  refuse(with(Up(deep), {"--block-glass", "butter"}), "butter");
  refuse(with(Up(deep), {"--lens", "f1000"}), "f1000");
  refuse(with(Up(deep), {"--machine", "nowhere"}), "nowhere");
  refuse(With({"up", "--folder", deep, "--machine", "mill"}),
         "mill has no virtual machine here");

  // A second shop in the same place of the bus.
  ASSERT_NO_FATAL_FAILURE(Open());
  const Ended second = Run(Up(deep));
  EXPECT_EQ(second.exit_code, 2) << second.output;
  EXPECT_THAT(second.output, HasSubstr("already runs"));
  EXPECT_FALSE(fs::exists(disk_ / "deep"));
  const Ended same = Run(Up(shop_));
  EXPECT_EQ(same.exit_code, 2) << same.output;
  EXPECT_THAT(same.output, HasSubstr("in use by the process"));
  EXPECT_TRUE(up_->running());
  EXPECT_TRUE(fs::exists(shop_ / "lock")) << "the lock is that of the open shop";
  Close();
}

TEST_F(Foreman, AForeignDatabaseIsRefusedUntouched) {
  fs::create_directories(shop_);
  std::ofstream(shop_ / "jobs.db", std::ios::binary)
      << "SQLite format 3" << std::string(4081, '\1');
  const auto before = ContentsOf(disk_);
  const Ended damaged = Run(Up(shop_));
  EXPECT_EQ(damaged.exit_code, 2) << damaged.output;
  EXPECT_THAT(damaged.output, HasSubstr((shop_ / "jobs.db").string()));
  EXPECT_THAT(damaged.output, HasSubstr("not changed"));
  EXPECT_EQ(ContentsOf(disk_), before);

  // One of ours, marked as that of a newer program: the version is at byte 60.
  ASSERT_NO_FATAL_FAILURE([&] {
    fs::remove(shop_ / "jobs.db");
    Open();
    Close();
  }());
  std::fstream file(shop_ / "jobs.db", std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(62).put('\x7f');
  file.close();
  const auto newer = ContentsOf(disk_);
  const Ended refused = Run(Up(shop_));
  EXPECT_EQ(refused.exit_code, 2) << refused.output;
  EXPECT_THAT(refused.output, HasSubstr("use the newer program"));
  EXPECT_EQ(ContentsOf(disk_), newer);

  // The job service started by hand refuses it as well.
  Running service(Program("intaglio-job-service"),
                  With({"--database", (shop_ / "jobs.db").string(), "--results",
                        (folder_ / "results").string(), "--materials-db",
                        (folder_ / "materials.db").string()}),
                  folder_ / "service.txt");
  const Ended ended = service.WaitForEnd(30s);
  EXPECT_EQ(ended.exit_code, 1) << ended.output;
  EXPECT_THAT(ended.output, HasSubstr("use the newer program"));
  EXPECT_EQ(ContentsOf(disk_), newer);
}

}  // namespace
}  // namespace intaglio
