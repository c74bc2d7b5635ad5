// The program virtual-engraver as a scan head, and hosts of it that are killed.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>

#include "services/platform/link/endpoint.h"
#include "tests/patience.h"
#include "tests/services/drivers/galvo/head_bench.h"
#include "tests/services/virtual_engraver/engraver_process.h"
#include "tests/test_folder.h"

namespace intaglio::drivers {
namespace {

using test::Eventually;
using virtual_engraver::EngraverProcess;
using virtual_engraver::ForkedHost;

std::unique_ptr<MarkDriver> HostAt(const std::filesystem::path& line) {
  return MakeGalvoDriver(HeadProfile(), link::EndpointOpener(line.string(), 115200),
                         link::MonotonicClock());
}

bool PollUntil(MarkDriver& driver, const std::function<bool()>& done) {
  return Eventually(
      [&] {
        driver.Poll();
        return done();
      },
      std::chrono::seconds(10));
}

/// A run of three marks, permitted until it ends: a computer that is busy for 250 ms ends
/// it.
void MarkOnce(MarkDriver& driver, std::uint32_t run) {
  if (!driver.Begin(run, std::array{mark::Pen{"fast", 1000, 0.5, 0, 1, 0, 0},
                                    mark::Pen{"slow", 1, 0.5, 0, 1, 0, 0}}))
    return;
  mark::Mark slow = LineMark({0, 1}, {20, 1});
  slow.pen = 1;
  (void)driver.Append({0, LineMark({0, 0}, {10, 0})});
  (void)driver.Append({1, slow});
  (void)driver.Append({2, LineMark({0, 2}, {10, 2})});
  while (driver.state().fault.empty() && !driver.state().safe_state) {
    (void)driver.Permit(true);
    driver.Poll();
    (void)driver.TakeEvents();
  }
}

void MarkForEver(const std::filesystem::path& line) {
  const auto driver = HostAt(line);
  for (std::uint32_t run = 5;; ++run) {
    (void)driver->Reset();
    const auto ready = [&] {
      const MarkDeviceState& state = driver->state();
      return state.link_up && state.settled && state.fault.empty() && !state.safe_state;
    };
    if (PollUntil(*driver, ready)) MarkOnce(*driver, run);
  }
}

TEST(GalvoProcess, AKilledHostClosesTheShutterAndTheHeadRemembersItsMarks) {
  const std::filesystem::path folder = test::FreshFolder();
  EngraverProcess head(folder, {},
                       {"--head-line", folder / "head", "--mark-record",
                        folder / "marks.rec", "--speed", "lockstep"});
  ASSERT_TRUE(head.AwaitReady());
  {
    ForkedHost host([&] { MarkForEver(folder / "head"); });
    ASSERT_TRUE(Eventually(
        [&] {
          const auto record = formats::ReadMarkRecord(folder / "marks.rec");
          return record && !record->ticks.empty() && record->ticks.back().mark == 1;
        },
        std::chrono::seconds(20)))
        << head.Ask("status") << head.program().Output();
    host.Signal(SIGKILL);
  }
  // 7: not permitted; bits 4 and 5 of the interlocks: shutter and laser.
  ASSERT_TRUE(Eventually([&] { return head.StatusOf("run_state") == "7"; },
                         std::chrono::seconds(5)));
  EXPECT_EQ(std::stoi(head.StatusOf("interlocks")) & 0x30, 0);
  const std::string burnt = head.StatusOf("burnt_ticks");
  const auto run = static_cast<std::uint32_t>(std::stoul(head.StatusOf("run")));

  const auto driver = HostAt(folder / "head");
  ASSERT_TRUE(PollUntil(*driver, [&] { return driver->state().link_up; }))
      << driver->state().message;
  ASSERT_TRUE(driver->RequestPast(run, 0, 3));
  std::vector<MarkEvent> events;
  ASSERT_TRUE(PollUntil(*driver, [&] {
    for (const MarkEvent& event : driver->TakeEvents()) events.push_back(event);
    return events.size() == 3;
  }));
  EXPECT_EQ(events[0].fate, MarkFate::kDone);
  EXPECT_EQ(events[1].fate, MarkFate::kBroken);
  EXPECT_EQ(events[2].fate, MarkFate::kNotBegun);
  EXPECT_TRUE(driver->state().safe_state);
  EXPECT_EQ(head.StatusOf("burnt_ticks"), burnt);
  EXPECT_EQ(head.Ask("door open"), "ok");
  ASSERT_TRUE(PollUntil(*driver, [&] { return !driver->state().door_closed; }));
  EXPECT_EQ(driver->state().openings, 1u);
}

}  // namespace
}  // namespace intaglio::drivers
