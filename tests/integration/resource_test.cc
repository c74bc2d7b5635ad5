// A shop short of a resource: stopped processes, disks without room, memory that is not
// granted. The machine is safe, the reason is reported, and the glass comes out as if
// nothing had happened. INTAGLIO_LONG=1: processes are stopped for 30 s instead of 5.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <iostream>
#include <set>

#include "engrave/formats/journal_file.h"
#include "tests/integration/shop_floor.h"
#include "tests/test_folder.h"
#include "tests/test_name.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::DifferenceOf;
using testing::Ended;
using testing::Eventually;
using ::testing::HasSubstr;
using testing::LongTests;
using testing::ShopFloor;
using Clock = std::chrono::steady_clock;

double Since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// The resident memory of a process, MB.
double ResidentOf(pid_t pid) {
  std::ifstream in("/proc/" + std::to_string(pid) + "/statm");
  long pages = 0, resident = 0;
  in >> pages >> resident;
  return static_cast<double>(resident * sysconf(_SC_PAGESIZE)) / 1e6;
}

class Resources : public ::testing::Test {
 protected:
  Resources() : folder_(test::FreshFolder()) {}

  void SetUp() override { ASSERT_FALSE(testing::UndisturbedPoints().empty()); }

  ShopFloor Floor(const fs::path& results = {}, const fs::path& database = {}) const {
    ShopFloor::Options options;
    options.bus = {"--domain", "56", "--tag", "resource" + std::to_string(getpid())};
    options.results = results;
    options.database = database;
    return ShopFloor(folder_, options);
  }
  static bool Begin(ShopFloor& floor, std::int64_t cracks = 60) {
    floor.StartAll();
    return floor.Engrave() && floor.AwaitCracks(cracks, 40s);
  }
  static void ExpectGood(ShopFloor& floor) {
    EXPECT_TRUE(floor.Reaches("done", 60s)) << floor.Logs();
    EXPECT_EQ(DifferenceOf(floor.Cracks()), "") << floor.Logs();
  }

  fs::path folder_;
};

// ---- Stopped processes
// -----------------------------------------------------------------

class IsFrozen : public Resources, public ::testing::WithParamInterface<const char*> {};

TEST_P(IsFrozen, AndTheGlassIsTheSame) {
  if (GetParam() != testing::kSynchronizer && !testing::LongTests()) {
    GTEST_SKIP() << "takes minutes: set INTAGLIO_LONG=1";
  }
  // Within the limit of absence: after more it waits for a person.
  const auto duration = LongTests() ? 20s : 5s;
  ShopFloor floor = Floor();
  ASSERT_TRUE(Begin(floor)) << floor.Logs();
  testing::Running& service = floor.at(GetParam());
  const double before = ResidentOf(floor.at(testing::kSynchronizer).pid());
  service.Signal(SIGSTOP);
  const std::int64_t stop_tick = floor.Panel("tick");
  std::this_thread::sleep_for(duration);
  const std::int64_t tick = floor.Panel("tick");
  std::int64_t last_tick = 0;
  for (const auto& crack : floor.Cracks()) {
    last_tick = std::max(last_tick, static_cast<std::int64_t>(crack.tick));
  }
  const std::int64_t cracks = floor.Panel("cracks");
  service.Signal(SIGCONT);
  const auto awake = Clock::now();
  const bool finished =
      cracks == static_cast<std::int64_t>(testing::UndisturbedPoints().size());
  if (!finished) {
    EXPECT_TRUE(floor.AwaitCracks(cracks + 1, 60s)) << floor.Logs();
  }
  std::cout << "  " << GetParam() << " stood still for " << tick - stop_tick
            << " ticks, last crack after " << last_tick - stop_tick << "; "
            << (finished ? "the job went on"
                         : "first crack " + std::to_string(Since(awake)) + " s after it")
            << "; synchronizer " << before << " -> "
            << ResidentOf(floor.at(testing::kSynchronizer).pid()) << " MB\n";
  ExpectGood(floor);
  EXPECT_LT(ResidentOf(floor.at(testing::kSynchronizer).pid()), before + 30);
}

INSTANTIATE_TEST_SUITE_P(Service, IsFrozen,
                         ::testing::Values(testing::kJobService, testing::kSynchronizer,
                                           testing::kBridge, testing::kDiscretizer,
                                           testing::kSorter),
                         [](const auto& row) { return test::AsTestName(row.param); });

// Readers that do not read: what is written to them neither waits nor grows.
TEST_F(Resources, WatchersThatAreFrozenCostNothing) {
  ShopFloor floor = Floor();
  floor.StartAll();
  ASSERT_TRUE(floor.Opens()) << floor.Logs();
  std::vector<std::unique_ptr<testing::Running>> watchers;
  ASSERT_TRUE(floor.Engrave()) << floor.Logs();
  for (int i = 0; i < 3; ++i) {
    watchers.push_back(std::make_unique<testing::Running>(
        testing::Program("intaglio"), floor.With({"watch", "1"}),
        folder_ / ("watcher" + std::to_string(i) + ".txt")));
  }
  ASSERT_TRUE(floor.AwaitCracks(30, 40s)) << floor.Logs();
  const double before = ResidentOf(floor.at(testing::kJobService).pid());
  for (const auto& watcher : watchers) watcher->Signal(SIGSTOP);
  const auto began = Clock::now();
  EXPECT_TRUE(floor.Reaches("done", 60s)) << floor.Logs();
  const double after = ResidentOf(floor.at(testing::kJobService).pid());
  std::cout << "  three watchers stand still: done in " << Since(began)
            << " s, job service " << before << " -> " << after << " MB\n";
  EXPECT_LT(after, before + 20);
  for (const auto& watcher : watchers) watcher->Signal(SIGCONT);
  for (const auto& watcher : watchers) {
    EXPECT_EQ(watcher->WaitForEnd(30s).exit_code, 0) << watcher->Output();
  }
  EXPECT_EQ(DifferenceOf(floor.Cracks()), "") << floor.Logs();
}

// ---- Disks
// -----------------------------------------------------------------------------

/// A file system of its own, seen by this program and what it starts.
class SmallDisk {
 public:
  SmallDisk(fs::path folder, int size_kb) : folder_(std::move(folder)) {
    fs::create_directories(folder_);
    const bool own = unshare(CLONE_NEWNS) == 0 &&
                     mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0;
    const std::string size = "size=" + std::to_string(size_kb) + "k";
    there_ = own && mount("tmpfs", folder_.c_str(), "tmpfs", 0, size.c_str()) == 0;
    if (!there_) why_ = std::strerror(errno);
  }
  ~SmallDisk() {
    if (there_) umount2(folder_.c_str(), MNT_DETACH);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

  bool there() const { return there_; }
  const std::string& why() const { return why_; }
  /// To the last byte.
  void Fill() const {
    std::ofstream out(folder_ / "full", std::ios::binary | std::ios::app);
    const std::string block(4096, 'x');
    while (out.write(block.data(), static_cast<std::streamsize>(block.size())).flush()) {
    }
  }
  void MakeRoom() const { fs::remove(folder_ / "full"); }

 private:
  fs::path folder_;
  bool there_ = false;
  std::string why_;
};

TEST_F(Resources, AFullDiskOfResultsPausesTheJob) {
  const SmallDisk disk(folder_ / "disk", 4096);
  if (!disk.there()) GTEST_SKIP() << "a small file system needs root: " << disk.why();
  ShopFloor floor = Floor(folder_ / "disk" / "results");
  ASSERT_TRUE(Begin(floor)) << floor.Logs();
  disk.Fill();
  ASSERT_TRUE(Eventually(
      [&] { return floor.Newest("message").find("journal") != std::string::npos; }, 20s))
      << floor.Logs();
  EXPECT_EQ(floor.Newest("state"), "paused");
  EXPECT_THAT(floor.Newest("message"), HasSubstr("journal.bin"));
  EXPECT_THAT(floor.Newest("message"), HasSubstr("No space left on device"));
  EXPECT_THAT(floor.Newest("message"), HasSubstr("free space"));
  std::cout << "  " << floor.Newest("message") << "\n";

  // It stays so while the disk is full, whatever the operator commands.
  EXPECT_EQ(floor.Type({"resume", "1"}).exit_code, 0);
  std::this_thread::sleep_for(2s);
  fs::path journal_file;
  for (const auto& entry : fs::recursive_directory_iterator(floor.results())) {
    if (entry.path().filename() == "journal.bin") journal_file = entry.path();
  }
  const auto journal = formats::ReadJournal(journal_file);
  ASSERT_TRUE(journal.has_value());
  std::set<std::uint32_t> intended;
  for (const auto& record : journal->records) {
    if (record.kind == formats::JournalKind::kIntent) intended.insert(record.point);
  }
  const auto cracks = floor.Cracks();
  EXPECT_LE(cracks.size(), intended.size());
  std::cout << "  " << cracks.size() << " cracks, " << intended.size()
            << " points intended in the journal\n";

  disk.MakeRoom();
  std::this_thread::sleep_for(1s);
  EXPECT_EQ(floor.Type({"resume", "1"}).exit_code, 0);
  ExpectGood(floor);
}

TEST_F(Resources, AFullDiskOfTheQueuePausesTheJob) {
  const SmallDisk disk(folder_ / "disk", 4096);
  if (!disk.there()) GTEST_SKIP() << "a small file system needs root: " << disk.why();
  ShopFloor floor = Floor({}, folder_ / "disk" / "jobs.db");
  ASSERT_TRUE(Begin(floor)) << floor.Logs();
  disk.Fill();
  // What the queue has to keep: an operator's command.
  (void)floor.Type({"pause", "1"});
  std::this_thread::sleep_for(1s);
  EXPECT_TRUE(floor.at(testing::kJobService).running());
  const std::int64_t cracks = floor.Panel("cracks");
  std::this_thread::sleep_for(1s);
  EXPECT_EQ(floor.Panel("cracks"), cracks);
  EXPECT_EQ(floor.Newest("state"), "paused");
  EXPECT_THAT(floor.Newest("message"), HasSubstr("jobs.db"));
  EXPECT_THAT(floor.Newest("message"), HasSubstr("free space"));
  std::cout << "  " << floor.Newest("message") << "\n";
  disk.MakeRoom();
  ASSERT_TRUE(Eventually(
      [&] { return floor.Newest("message").find("jobs.db") == std::string::npos; }, 20s))
      << floor.Logs();
  EXPECT_EQ(floor.Type({"resume", "1"}).exit_code, 0);
  ExpectGood(floor);
}

// ---- Memory
// ----------------------------------------------------------------------------

// The points of a large job do not fit: the process reports it and ends, and the job goes
// on with the next one, once a person has armed it for the block that is in the machine
// then.
TEST_F(Resources, AServiceWithoutMemoryEndsAndTheJobWaitsForTheNext) {
  ShopFloor floor = Floor();
  floor.StartAll();
  ASSERT_TRUE(floor.Opens()) << floor.Logs();
  testing::Running& sorter = floor.at(testing::kSorter);
  std::ifstream in("/proc/" + std::to_string(sorter.pid()) + "/statm");
  rlim_t pages = 0;
  in >> pages;
  const rlim_t bytes = pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + (1u << 20);
  const rlimit limit{bytes, bytes};
  ASSERT_EQ(prlimit(sorter.pid(), RLIMIT_AS, &limit, nullptr), 0);
  const Ended submitted = floor.Type(
      {"submit", std::string(INTAGLIO_SOURCE_DIR) + "/deploy/jobs/sample.textproto",
       "--height", "20", "--spacing", "0.12", "--rate", "100"});
  ASSERT_EQ(submitted.exit_code, 0) << submitted.output << floor.Logs();
  const Ended ended = sorter.WaitForEnd(40s);
  EXPECT_TRUE(ended.in_time) << floor.Logs();
  EXPECT_EQ(ended.exit_code, 1) << "a message, not a signal";
  EXPECT_THAT(ended.output, HasSubstr("no more memory"));
  EXPECT_EQ(floor.Panel("cracks"), 0);
  EXPECT_EQ(floor.Type({"arm", "1"}).exit_code, 4) << "its machine does not have it";
  floor.Start(testing::kSorter);
  EXPECT_TRUE(Eventually(
      [&] {
        return floor.Type({"arm", "1"}).exit_code == 0;
      },
      30s))
      << floor.Logs();
  EXPECT_TRUE(floor.AwaitCracks(10, 90s)) << floor.Logs();
}

}  // namespace
}  // namespace intaglio
