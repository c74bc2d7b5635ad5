// A console whose clients are slow, many or broken, all at once: the job does not notice,
// an ordinary request is answered, and every stop is confirmed.

#include "tests/integration/console_load.h"

#include <unistd.h>

#include <fstream>
#include <iostream>
#include <vector>

#include "tests/integration/console_shop.h"

namespace intaglio {
namespace {

using namespace std::chrono_literals;
using namespace intaglio::testing;
using test::WebAnswer;
using test::WebConnection;
using ::testing::HasSubstr;
using ::testing::Not;

// An answer that takes longer hangs; the figures that matter are printed.
constexpr double kHangsMs = 20'000;
constexpr auto kHangs = 20s;

class ConsoleUnderLoad : public ConsoleShop {
 protected:
  void StartLoad() {
    load_ = std::make_unique<ConsoleLoad>(port_, key_, LoadOptions());
    load_began_ = std::chrono::steady_clock::now();
    ASSERT_TRUE(Eventually([&] { return load_->answered_count() > 100; }, kHangs));
  }
  /// The console took it, and what it costs.
  void EndLoad() {
    const std::chrono::duration<double> lasted =
        std::chrono::steady_clock::now() - load_began_;
    const double resident_mb = MemoryMb();
    std::cout << "for " << lasted.count() << " s "
              << load_->answered_count() / lasted.count()
              << " requests a second were answered, " << load_->refused_count()
              << " were not; " << load_->broken_count()
              << " connections ended by a malformed frame; the console has "
              << resident_mb << " MB; load " << LoadAverage() << "\n";
    EXPECT_GT(load_->broken_count(), 20);
    EXPECT_EQ(load_->survived_count(), 0);
    EXPECT_EQ(load_->refused_count(), 0);
    EXPECT_GT(resident_mb, 1);
    EXPECT_LT(resident_mb, 100);
    EXPECT_TRUE(console_->running()) << console_->Output();
    EXPECT_THAT(console_->Output(), Not(HasSubstr("error")));
    load_.reset();
  }
  void Print(const std::string& what, const std::vector<double>& times_ms) {
    std::cout << what << ", ms: median " << Share(times_ms, 0.5) << ", p99 "
              << Share(times_ms, 0.99) << ", largest " << Share(times_ms, 1) << " of "
              << times_ms.size() << "\n";
    EXPECT_LT(Share(times_ms, 1), kHangsMs);
  }
  static double LoadAverage() {
    double load = 0;
    std::ifstream("/proc/loadavg") >> load;
    return load;
  }
  /// The memory of the console.
  double MemoryMb() const {
    double size_pages = 0, resident_pages = 0;
    std::ifstream("/proc/" + std::to_string(console_->pid()) + "/statm") >> size_pages >>
        resident_pages;
    return resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
  }
  /// Ticks from the first crack to the last.
  static std::uint64_t TicksOfTheJob(const ShopFloor& floor) {
    std::uint64_t first = UINT64_MAX, last = 0;
    for (const formats::GlassCrack& crack : floor.Cracks()) {
      first = std::min(first, crack.tick);
      last = std::max(last, crack.tick);
    }
    return last - first;
  }
  std::uint64_t TicksWithoutLoad() const;

  std::unique_ptr<ConsoleLoad> load_;
  std::chrono::steady_clock::time_point load_began_;
};

const std::vector<std::string> kJob = {"--height", "4.2",    "--spacing",
                                       "0.5",      "--rate", "25"};

/// The ticks of the job in a shop without a console.
std::uint64_t ConsoleUnderLoad::TicksWithoutLoad() const {
  ShopFloor::Options options = OnABusOfItsOwn();
  options.bus.back() += "quiet";
  std::filesystem::create_directories(folder_ / "quiet");
  ShopFloor quiet(folder_ / "quiet", options);
  quiet.StartAll();
  EXPECT_TRUE(quiet.Engrave(kJob)) << quiet.Logs();
  EXPECT_TRUE(quiet.Reaches("done", 120s)) << quiet.Logs();
  return TicksOfTheJob(quiet);
}

TEST_F(ConsoleUnderLoad, TheJobDoesNotNotice) {
  const std::uint64_t quiet_ticks = TicksWithoutLoad();
  floor_.StartAll();
  Open();
  ASSERT_TRUE(floor_.Opens()) << floor_.Logs();
  StartLoad();
  job_ = floor_.Engrave(kJob);
  ASSERT_TRUE(job_);
  std::vector<double> answer_ms;
  const bool done = Eventually(
      [&] {
        const WebAnswer answer = Get("/api/v1/status");
        EXPECT_EQ(answer.status, 200);
        answer_ms.push_back(answer.seconds * 1000);
        return floor_.Newest("state") == "done";
      },
      120s);
  ASSERT_TRUE(done) << floor_.Logs();
  Print("an ordinary request", answer_ms);
  EndLoad();
  EXPECT_THAT(Job(), HasSubstr("\"missed\": 0"));
  EXPECT_THAT(Job(), HasSubstr("\"uncertain\": 0"));
  EXPECT_THAT(floor_.Events(), Not(HasSubstr("\"state\":\"paused\"")));
  EXPECT_EQ(DifferenceOf(floor_.Cracks()), "") << floor_.Logs();
  EXPECT_EQ(TicksOfTheJob(floor_), quiet_ticks);
  std::cout << "the job took " << TicksOfTheJob(floor_) << " ticks, without load "
            << quiet_ticks << "\n";
}

// A stop that is not confirmed is answered after a second, so each is confirmed by then.
// The job service is killed in between: no stop needs it.
TEST_F(ConsoleUnderLoad, EveryStopIsConfirmed) {
  EngraveSome();
  StartLoad();
  std::vector<double> stop_ms, message_ms;
  WebConnection control(port_);
  control.Send(test::Upgrade(port_, "/control", key_));
  ASSERT_THAT(control.ReadUntil("\r\n\r\n", kHangs), HasSubstr(" 101 "));
  for (int i = 0; i < 100; ++i) {
    if (i == 50) floor_.at(kJobService).Signal(SIGKILL);
    const WebAnswer stopped = Post("/api/v1/stop");
    ASSERT_EQ(stopped.status, 200) << stopped.body;
    EXPECT_THAT(stopped.body, HasSubstr("\n \"confirmed\": true")) << stopped.body;
    stop_ms.push_back(stopped.seconds * 1000);
    // By the WebSocket: the state says within its next tenth of a second.
    const auto sent = std::chrono::steady_clock::now();
    control.Send(test::Frame(R"({"stop": {}})"));
    const std::string confirmed = fmt::format(
        "\"stop\":{{\"sent\":true,\"number\":{},\"confirmed\":true", 2 * i + 2);
    ASSERT_TRUE(Eventually(
        [&] {
          const auto text = test::ReadFrame(control, kHangs);
          return text && text->find(confirmed) != std::string::npos;
        },
        kHangs))
        << confirmed;
    message_ms.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - sent)
            .count());
  }
  ExpectNothingFires();
  Print("from the request to the confirmation by the machine", stop_ms);
  Print("from the message to the state with the confirmation", message_ms);
  EndLoad();
}

}  // namespace
}  // namespace intaglio
