// A shop: services kept running by `intaglio up`, commands from other processes.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <fstream>
#include <regex>

#include "services/platform/bus/bus.h"
#include "services/platform/bus/samples.h"
#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::Ended;
using testing::Eventually;
using ::testing::HasSubstr;
using testing::Program;
using testing::Running;

class Shop : public ::testing::Test {
 protected:
  Shop() { Open({"50", "50", "30"}); }

  void Open(const std::vector<std::string>& block_mm,
            const std::vector<std::string>& more = {}) {
    std::vector<std::string> words = {
        "up",      "--folder", folder_ / "shop", "--materials", folder_ / "materials.db",
        "--speed", "5",        "--warm-up",      "5",           "--record",
        "--block"};
    words.insert(words.end(), block_mm.begin(), block_mm.end());
    words.insert(words.end(), more.begin(), more.end());
    up_ = std::make_unique<Running>(Program("intaglio"), With(words),
                                    folder_ / ("up" + block_mm[0] + ".txt"));
  }
  void Close() {
    up_->Signal(SIGINT);
    const Ended ended = up_->WaitForEnd(15s);
    EXPECT_TRUE(ended.in_time);
    EXPECT_EQ(ended.exit_code, 0) << ended.output;
  }

  /// A domain of its own by the tag: participants of other tests are not seen, nor those
  /// of the test before, whose shop may still be ending.
  std::vector<std::string> With(std::vector<std::string> words) const {
    for (const std::string& word :
         {std::string("--domain"), std::string("44"), std::string("--tag"), tag_}) {
      words.push_back(word);
    }
    return words;
  }
  Ended Type(const std::vector<std::string>& words) {
    Running run(Program("intaglio"), With(words),
                folder_ / ("typed" + std::to_string(++typed_) + ".txt"));
    return run.WaitForEnd(60s);
  }
  /// Runs a command that needs no shop.
  Ended Ask(const std::vector<std::string>& words) {
    Running run(Program("intaglio"), words,
                folder_ / ("typed" + std::to_string(++typed_) + ".txt"));
    return run.WaitForEnd(60s);
  }
  /// Exit code 4: the job may fail while it is submitted, and the reason is printed.
  std::string Submit(std::vector<std::string> more, bool is_refused = false) {
    std::vector<std::string> words = {
        "submit", std::string(INTAGLIO_SOURCE_DIR) + "/deploy/jobs/sample.textproto",
        "--height", "6"};
    words.insert(words.end(), more.begin(), more.end());
    const Ended ended = Type(words);
    if (is_refused && ended.exit_code == 4) {
      EXPECT_THAT(ended.output, HasSubstr("failed: "));
    } else {
      EXPECT_EQ(ended.exit_code, 0) << ended.output;
    }
    std::smatch number;
    EXPECT_TRUE(std::regex_search(ended.output, number, std::regex("job ([0-9]+)")))
        << ended.output;
    return number[1];
  }
  /// Waits until `intaglio show` has the state.
  bool Reaches(const std::string& job, const std::string& state) {
    return Eventually(
        [&] {
          last_ = Type({"show", job}).output;
          return last_.find("state      " + state) != std::string::npos;
        },
        40s);
  }

  /// The same for a job under way. A machine in real time may pause by itself when this
  /// host is too busy for its lines; the operator then does what the message asks for.
  /// False at once where it has ended in another state.
  bool RunsTo(const std::string& job, const std::string& state) {
    const auto is_in = [this](const std::string& other) {
      return last_.find("state      " + other) != std::string::npos;
    };
    return Eventually(
               [&] {
                 last_ = Type({"show", job}).output;
                 if (is_in(state) || is_in("done") || is_in("failed") ||
                     is_in("cancelled")) {
                   return true;
                 }
                 if (is_in("paused")) Type({"resume", job});
                 return false;
               },
               60s) &&
           is_in(state);
  }

  /// Pulses that the machine has fired; 0 before it is there.
  unsigned long Pulses() const {
    const std::string status = testing::AskPanel(folder_ / "shop", "status");
    std::smatch number;
    return std::regex_search(status, number, std::regex("\"pulses\": ([0-9]+)"))
               ? std::stoul(number[1])
               : 0;
  }

  static std::string FreshTag() {
    static int number = 0;
    return "shop" + std::to_string(getpid()) + "-" + std::to_string(++number);
  }

  fs::path folder_ = test::FreshFolder();
  const std::string tag_ = FreshTag();
  std::unique_ptr<Running> up_;
  std::string last_;
  int typed_ = 0;
};

TEST_F(Shop, EngravesTwoJobsOneAfterTheOtherWithAPauseBetween) {
  // It lasts long enough that a command reaches it on a computer of a sixth of the speed.
  const std::string first = Submit({"--rate", "25"});
  ASSERT_TRUE(Reaches(first, "waiting for arm")) << last_;
  // Its machine has another job's block: it is not armed, also not for later.
  const Ended waits =
      Type({"submit", std::string(INTAGLIO_SOURCE_DIR) + "/deploy/jobs/sample.textproto",
            "--height", "6", "--arm", "--watch"});
  EXPECT_EQ(waits.exit_code, 4);
  EXPECT_THAT(waits.output,
              HasSubstr("job 2 stays queued and is not armed (waits for its "
                        "turn on els-03"));
  const std::string second = "2";
  EXPECT_NE(first, second);

  // The first job's block is in the machine: the second cannot be armed for it.
  const Ended early = Type({"arm", second});
  EXPECT_EQ(early.exit_code, 4);
  EXPECT_THAT(early.output,
              HasSubstr("cannot be armed yet: waits for its turn on els-03"));

  EXPECT_EQ(Type({"arm", first}).exit_code, 0);
  ASSERT_TRUE(RunsTo(first, "engraving")) << last_;
  EXPECT_EQ(Type({"pause", first}).exit_code, 0);
  ASSERT_TRUE(Reaches(first, "paused")) << last_;
  EXPECT_EQ(Type({"resume", first}).exit_code, 0);
  ASSERT_TRUE(RunsTo(first, "done")) << last_;
  const Ended watched = Type({"watch", first});
  EXPECT_EQ(watched.exit_code, 0) << watched.output;
  EXPECT_THAT(watched.output, HasSubstr("done"));

  ASSERT_TRUE(Reaches(second, "waiting for arm")) << last_;
  EXPECT_EQ(Type({"cancel", second}).exit_code, 0);
  ASSERT_TRUE(Reaches(second, "cancelled")) << last_;
  const Ended list = Type({"list"});
  EXPECT_THAT(list.output, HasSubstr("done"));
  EXPECT_THAT(list.output, HasSubstr("cancelled"));

  Close();
}

// Its points would come at other depths. Nothing is lost: the queue knows of the job.
TEST_F(Shop, AJobForAnotherBlockIsNotFiredAndKeptForTheRightOne) {
  const std::string job = Submit({"--block", "60", "55", "20"});
  ASSERT_TRUE(Reaches(job, "waiting for arm")) << last_;
  EXPECT_THAT(last_, HasSubstr("for a block of 60 x 55 x 20 mm"));
  EXPECT_THAT(last_, HasSubstr("the one in the machine has 50 x 50 x 30 mm"));
  EXPECT_THAT(last_, HasSubstr("`intaglio mount --machine els-03 --block 60 55 20`"));
  const Ended refused = Type({"arm", job});
  EXPECT_EQ(refused.exit_code, 4) << refused.output;
  EXPECT_THAT(refused.output, HasSubstr("refused, not_mounted"));
  EXPECT_EQ(Pulses(), 0u);
  Close();
  Open({"60", "55", "20"});
  ASSERT_TRUE(Eventually([&] { return Type({"arm", job}).exit_code == 0; }, 40s));
  EXPECT_TRUE(RunsTo(job, "done")) << last_;
}

// The depth of every point follows from both.
TEST_F(Shop, AJobForAnotherLensOrGlassIsNotFiredAndKeptForTheRightOnes) {
  ASSERT_TRUE(Eventually(
      [this] { return up_->Output().find("the shop is open") != std::string::npos; },
      40s));
  Close();
  Open({"50", "50", "30"}, {"--lens", "f70", "--block-glass", "fused-silica"});
  const std::string job = Submit({});
  ASSERT_TRUE(Reaches(job, "waiting for arm")) << last_;
  EXPECT_EQ(Type({"arm", job}).exit_code, 4);
  EXPECT_THAT(last_, HasSubstr("the job is for the lens f43"));
  EXPECT_THAT(last_, HasSubstr("the lens f70 (f 70 mm, NA 0.0357) is mounted"));
  EXPECT_THAT(last_, HasSubstr("the job is for N-BK7 (refractive index 1.519"));
  EXPECT_THAT(last_, HasSubstr("has the index 1.460"));
  Close();
  Open({"50", "50", "30"});
  EXPECT_TRUE(Eventually([this] {
    return up_->Output().find("N-BK7 of index 1.519") != std::string::npos &&
           up_->Output().find("lens f43: f 43 mm, NA 0.0581") != std::string::npos;
  }));
  ASSERT_TRUE(Eventually([&] { return Type({"arm", job}).exit_code == 0; }, 40s));
  EXPECT_TRUE(RunsTo(job, "done")) << last_;
}

// The cell trusts its own profile, not the file of the person who submits.
TEST_F(Shop, AJobWithAProfileThatIsNotTheCellsIsRefused) {
  const fs::path profile = folder_ / "els-03.textproto";
  std::stringstream own;
  own << std::ifstream(INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto").rdbuf();
  std::ofstream(profile) << std::regex_replace(
      own.str(), std::regex("travel_max_mm: 172"), "travel_max_mm: 400");
  const std::string job = Submit({"--machine", profile}, true);
  ASSERT_TRUE(Reaches(job, "failed")) << last_;
  EXPECT_THAT(last_, HasSubstr("x.travel_max_mm is 400 in the job's profile and 172"));
  EXPECT_THAT(last_, HasSubstr("z.travel_max_mm"));
  EXPECT_THAT(last_, HasSubstr("submit it again with the profile of this cell"));
}

// People close a shop to change the block, and open it again.
TEST_F(Shop, ClosedInMidJobItFiresNothingWhenItIsOpenedAgain) {
  const std::string job = Submit({"--rate", "25", "--arm"});
  ASSERT_TRUE(RunsTo(job, "engraving")) << last_;
  Close();
  Open({"50", "50", "30"});
  ASSERT_TRUE(Eventually([&] { return Type({"show", job}).exit_code == 0; }, 40s));
  // Longer than the lamp of this shop's machine takes to be warm.
  std::this_thread::sleep_for(4s);
  const std::string shown = Type({"show", job}).output;
  EXPECT_THAT(shown, HasSubstr("state      paused"));
  EXPECT_THAT(shown, HasSubstr("disarmed   the shop was closed"));
  EXPECT_EQ(Type({"resume", job}).exit_code, 0);
  EXPECT_TRUE(Reaches(job, "engraving")) << last_;
}

/// The folder of the only job.
fs::path FolderOfTheJob(const fs::path& shop) {
  return fs::directory_iterator(shop / "jobs")->path();
}

bool IsComplete(const fs::path& job) {
  return fs::exists(job / "report.json") && fs::exists(job / "views.png") &&
         fs::exists(job / "customer.png");
}

// The block stays in the machine while the shop is closed, so that its glass has the
// cracks of two virtual engravers.
TEST_F(Shop, TheFolderOfAJobHasItsProofAndPicturesAlsoAfterARestartInIt) {
  const std::string job = Submit({"--rate", "50", "--arm"});
  ASSERT_TRUE(RunsTo(job, "engraving")) << last_;
  ASSERT_TRUE(Eventually([&] { return Pulses() > 20; }, 20s));
  Close();
  Open({"50", "50", "30"}, {"--background", "transparent", "--picture-size", "800"});
  ASSERT_TRUE(Eventually([&] { return Type({"show", job}).exit_code == 0; }, 40s));
  Type({"resume", job});
  ASSERT_TRUE(RunsTo(job, "done")) << last_;
  const fs::path folder = FolderOfTheJob(folder_ / "shop");
  ASSERT_TRUE(Eventually([&] { return IsComplete(folder); }, 60s)) << up_->Output();
  const std::string report = testing::TextIn(folder / "report.json");
  EXPECT_THAT(report, HasSubstr("\"evidence\": \"glass\""));
  EXPECT_THAT(report, HasSubstr("\"kind\": \"good\""));
  EXPECT_THAT(report, HasSubstr("\"estimate_ticks\""));
  const Ended history =
      Ask({"history", "--folder", (folder_ / "shop").string(), "--json"});
  EXPECT_THAT(history.output, HasSubstr((folder / "report.json").string()));
  const Ended verified = Ask({"verify", folder.string()});
  EXPECT_EQ(verified.exit_code, 0) << verified.output;
  EXPECT_THAT(verified.output, HasSubstr("0 doubled, 0 stray"));

  // As the folder of a real machine's job, away from all glass.
  const fs::path away = folder_ / "a" / "b" / "c";
  fs::create_directories(away);
  for (const char* file : {"path.ply", "job.json", "journal.bin", "statistics.json"}) {
    fs::copy_file(folder / file, away / file);
  }
  const Ended counted = Ask({"verify", away.string(), "--customer-picture"});
  EXPECT_EQ(counted.exit_code, 0) << counted.output;
  EXPECT_THAT(counted.output, HasSubstr("the laser controller's counters"));
  EXPECT_TRUE(IsComplete(away));

  // What is missing comes at the next start.
  fs::remove(folder / "views.png");
  Close();
  Open({"50", "50", "30"});
  EXPECT_TRUE(Eventually([&] { return IsComplete(folder); }, 60s)) << up_->Output();
}

TEST_F(Shop, TheHistoryNamesTheRecordingOfAJob) {
  const std::string job = Submit({"--arm"});
  ASSERT_TRUE(RunsTo(job, "done")) << last_;
  Running asked(Program("intaglio"),
                {"history", "--folder", (folder_ / "shop").string(), "--json"},
                folder_ / "history.txt");
  const Ended history = asked.WaitForEnd(30s);
  ASSERT_EQ(history.exit_code, 0) << history.output;
  std::smatch name;
  ASSERT_TRUE(std::regex_search(history.output, name,
                                std::regex("\"recording\": *\"([^\"]+mcap)\"")))
      << history.output;
  up_.reset();  // the last samples are in it once the shop is closed
  Running info(Program("intaglio"), {"recording", "info", name[1]}, folder_ / "info.txt");
  const Ended reported = info.WaitForEnd(30s);
  EXPECT_EQ(reported.exit_code, 0) << reported.output;
  EXPECT_THAT(reported.output, HasSubstr("frozen_job.binpb"));
}

TEST_F(Shop, AnEmergencyStopHoldsUntilItIsResetAndArmedAnew) {
  const std::string job = Submit({"--rate", "50"});  // long enough to be stopped in it
  ASSERT_TRUE(Reaches(job, "waiting for arm")) << last_;
  EXPECT_EQ(Type({"arm", job}).exit_code, 0);
  ASSERT_TRUE(RunsTo(job, "engraving")) << last_;
  const Ended stopped = Type({"stop", "--reason", "a hand in the machine"});
  EXPECT_EQ(stopped.exit_code, 0) << stopped.output;
  EXPECT_THAT(stopped.output, HasSubstr("els-03: stopped"));
  ASSERT_TRUE(Reaches(job, "paused")) << last_;
  const Ended resumed = Type({"resume", job});
  EXPECT_EQ(resumed.exit_code, 4);
  EXPECT_THAT(resumed.output, HasSubstr("the emergency stop of els-03 is pressed"));
  const Ended reset = Type({"stop", "els-03", "--reset"});
  EXPECT_EQ(reset.exit_code, 0) << reset.output;
  std::this_thread::sleep_for(1s);  // nothing starts by itself
  EXPECT_THAT(Type({"show", job}).output, HasSubstr("state      paused"));
  Type({"resume", job});
  EXPECT_TRUE(RunsTo(job, "done")) << last_;
}

/// The presses that hold els-03, and a reset that names what its sender chooses.
class StopsOnTheBus {
 public:
  explicit StopsOnTheBus(const std::string& tag) : bus_(OptionsOf(tag)) {}

  using Presses = std::vector<std::pair<std::string, std::uint64_t>>;
  Presses Held() {
    interlocks_.Take([this](const intaglio_Interlock& sample) {
      held_.clear();
      for (const intaglio_StopPress& press : bus::View(sample.bus_stops))
        held_.emplace_back(press.source, press.number);
    });
    return held_;
  }
  bool AwaitHeld(std::size_t count) {
    return Eventually([&] { return Held().size() == count; }, 10s);
  }
  void Reset(const Presses& presses) {
    std::vector<intaglio_StopPress> released;
    for (const auto& [source, number] : presses)
      released.push_back({bus::Borrow(source), number});
    const std::string who = "panel-" + std::to_string(getpid());
    intaglio_EmergencyStop sample{};
    sample.cell = bus::Borrow(kCell);
    sample.source = sample.operator_name = sample.reason = bus::Borrow(who);
    sample.number = 1;
    bus::Borrow(sample.released, released);
    EXPECT_TRUE(stops_.Write(sample));
  }

 private:
  static bus::BusOptions OptionsOf(const std::string& tag) {
    bus::BusOptions options;
    options.control_domain = 44;
    options.tag = tag;
    return options;
  }
  const std::string kCell = "els-03";
  bus::Bus bus_;
  bus::Reader<intaglio_Interlock> interlocks_{bus_, bus::kInterlock, kCell};
  bus::Writer<intaglio_EmergencyStop> stops_{bus_, bus::kEmergencyStop, kCell};
  Presses held_;
};

// Two people press; a third knows of the first press alone.
TEST_F(Shop, AResetLeavesThePressThatItsSenderDidNotKnowOf) {
  StopsOnTheBus stops(tag_);
  const std::string job = Submit({"--rate", "50"});
  ASSERT_TRUE(Reaches(job, "waiting for arm")) << last_;
  EXPECT_EQ(Type({"arm", job}).exit_code, 0);
  ASSERT_TRUE(RunsTo(job, "engraving")) << last_;
  ASSERT_TRUE(Eventually([&] { return Pulses() > 0; }, 60s)) << "or it tests nothing";
  const Ended stopped = Type({"stop"});
  EXPECT_EQ(stopped.exit_code, 0) << stopped.output;
  const auto pulses = Pulses();
  ASSERT_TRUE(stops.AwaitHeld(1));
  const StopsOnTheBus::Presses first = stops.Held();
  EXPECT_EQ(Type({"stop", "els-03"}).exit_code, 0);
  ASSERT_TRUE(stops.AwaitHeld(2));
  stops.Reset(first);
  ASSERT_TRUE(stops.AwaitHeld(1));
  EXPECT_NE(stops.Held(), first);
  EXPECT_THAT(Type({"resume", job}).output, HasSubstr("emergency stop"));
  EXPECT_FALSE(Eventually([&] { return Pulses() != pulses; }, 2s)) << "no more cracks";
  const Ended reset = Type({"stop", "--reset"});
  EXPECT_EQ(reset.exit_code, 0) << reset.output;
  EXPECT_TRUE(stops.AwaitHeld(0));
  EXPECT_FALSE(Eventually([&] { return Pulses() != pulses; }, 1s)) << "nor by itself";
  Type({"resume", job});
  EXPECT_TRUE(RunsTo(job, "done")) << last_;
}

// One that is at work is there, too: a computer more, for a shop that engraves.
TEST_F(Shop, OpensBesideASynchronizerThatIsEngraving) {
  const std::string job = Submit({"--rate", "1", "--arm"});  // for minutes
  ASSERT_TRUE(RunsTo(job, "engraving")) << last_;
  Running workers(Program("intaglio"),
                  With({"up", "--folder", folder_ / "workers", "--materials",
                        folder_ / "materials.db", "--real-machine", "--without",
                        "job-service", "synchronizer", "motion-bridge"}),
                  folder_ / "workers.txt");
  EXPECT_TRUE(Eventually(
      [&] { return workers.Output().find("the shop is open") != std::string::npos; },
      25s))
      << workers.Output();
  EXPECT_THAT(Type({"show", job}).output,
              ::testing::ContainsRegex("state      (engraving|paused)"))
      << "or the test tests nothing";
  workers.Signal(SIGINT);
  EXPECT_EQ(workers.WaitForEnd(15s).exit_code, 0);
}

// Two queues on one database, or two synchronizers on one laser, would spoil a block.
TEST_F(Shop, IsNotOpenedASecondTime) {
  ASSERT_TRUE(Eventually([&] { return Type({"list"}).exit_code == 0; }, 20s));
  const Ended same_folder = Type({"up", "--folder", (folder_ / "shop").string()});
  EXPECT_EQ(same_folder.exit_code, 2);
  EXPECT_THAT(same_folder.output, HasSubstr(std::to_string(up_->pid())));
  const Ended same_domain = Type({"up", "--folder", (folder_ / "other").string()});
  EXPECT_EQ(same_domain.exit_code, 2);
  EXPECT_THAT(same_domain.output, HasSubstr("already runs"));
  EXPECT_TRUE(up_->running());
}

TEST_F(Shop, ASubmissionWithMistakesIsRefusedWithAllOfThem) {
  ASSERT_TRUE(Eventually([&] { return Type({"list"}).exit_code == 0; }, 20s));
  const Ended ended =
      Type({"submit", std::string(INTAGLIO_SOURCE_DIR) + "/deploy/jobs/sample.textproto",
            "--rate", "123", "--margin", "-1"});
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_THAT(ended.output, HasSubstr("margin"));
  EXPECT_THAT(ended.output, HasSubstr("rate"));
}

}  // namespace
}  // namespace intaglio
