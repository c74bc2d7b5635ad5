// What becomes of the reports of a machine's services on their way through the job
// service, by a clock of the test's own.

#include "services/job_service/published/known_services.h"

#include <gmock/gmock.h>

#include "services/client/shop/known_machines.h"
#include "services/platform/bus/role_names.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/peers/machine_reporter.h"
#include "tests/services/platform/bus/private_bus.h"

namespace intaglio::job_service {
namespace {

using namespace std::chrono_literals;
using bus::Borrow;
using ::testing::IsEmpty;

intaglio_Interlock InterlockOf(bool door_closed) {
  static const std::string kCell = "mill", kText, kOpen = "clamp", kOn = "air";
  intaglio_Interlock sample{};
  sample.cell = Borrow(kCell);
  sample.message = Borrow(kText);
  sample.laser_link_up = sample.key_on = true;
  sample.door_closed = door_closed;
  sample.open_input = Borrow(kOpen);
  sample.outputs_on = Borrow(kOn);
  return sample;
}

class KnownService : public testing::Test {
 protected:
  void ReportHealth(std::chrono::nanoseconds now) {
    const std::string cell = "mill", text;
    intaglio_ServiceHealth health{};
    health.instance = Borrow(instance_);
    health.role = intaglio_ROLE_SYNCHRONIZER;
    health.state = intaglio_HEALTH_READY;
    health.cell = Borrow(cell);
    health.host = health.job_uid = health.version = health.message = Borrow(text);
    known_.Update(health, now);
  }
  template <typename Condition>
  bool Becomes(const Condition& condition, std::chrono::nanoseconds now) {
    return test::Eventually([&] {
      known_.Turn(now);
      machines_.Poll();
      return condition();
    });
  }
  bool ShowsDoorClosed(bool closed) const {
    const auto machines = machines_.machines();
    const auto mill = machines.find("mill");
    return mill != machines.end() && mill->second.has_interlock &&
           mill->second.door_closed == closed && mill->second.open_input == "clamp" &&
           mill->second.outputs_on == "air";
  }

  bus::Bus bus_{test::PrivateBusOptions({}, bus::kJobServiceRole)};
  bus::Bus cell_bus_{test::PrivateBusOptions("mill", bus::CellRole("mill"))};
  const std::string instance_ = "synchronizer-1-" + cell_bus_.participant_name();
  host::MachineReporter reporter_{cell_bus_, instance_};
  KnownServices known_{bus_};
  client::KnownMachines machines_{bus_};
};

TEST_F(KnownService, HasTheNewestFactsOfItsMachineUntilItIsGone) {
  ReportHealth(100s);
  reporter_.Update(InterlockOf(true));
  reporter_.Turn(100s);
  ASSERT_TRUE(Becomes([&] { return ShowsDoorClosed(true); }, 100s));
  reporter_.Update(InterlockOf(false));
  reporter_.Turn(101s);
  EXPECT_TRUE(Becomes([&] { return ShowsDoorClosed(false); }, 101s));
  known_.Remove(instance_);
  EXPECT_TRUE(Becomes([&] { return machines_.services().empty(); }, 101s));
  EXPECT_THAT(machines_.machines(), IsEmpty());
}

// A service whose loop hangs is alive on the bus, and reports nothing any more.
TEST_F(KnownService, OfASilentServiceIsPublishedWithItsAge) {
  ReportHealth(100s);
  const auto age = [&] {
    const auto services = machines_.services();
    if (services.size() != 1) return std::chrono::nanoseconds(-1);
    return std::chrono::nanoseconds(std::chrono::steady_clock::now() -
                                    services[0].reported_at);
  };
  ASSERT_TRUE(Becomes([&] { return age() >= 0s; }, 100s));
  EXPECT_LT(age(), 30s);
  EXPECT_TRUE(Becomes([&] { return age() >= 60s; }, 160s));
  ReportHealth(161s);
  EXPECT_TRUE(Becomes([&] { return age() < 30s; }, 161s));
}

// The instance of a report names its writer.
TEST_F(KnownService, TakesNoFactsOfAnotherProcess) {
  ReportHealth(100s);
  reporter_.Update(InterlockOf(true));
  reporter_.Turn(100s);
  ASSERT_TRUE(Becomes([&] { return ShowsDoorClosed(true); }, 100s));
  bus::Reader<intaglio_MachineReport> reports(bus_, bus::kMachineReport);
  host::MachineReporter forger(bus_, instance_);
  forger.Update(InterlockOf(false));
  forger.Turn(100s);
  bool came = false;
  ASSERT_TRUE(Becomes(
      [&] {
        reports.Take([&](const intaglio_MachineReport& report) {
          came = came || !report.facts.door_closed;
        });
        return came;
      },
      100s));
  known_.Turn(100s);
  machines_.Poll();
  EXPECT_TRUE(ShowsDoorClosed(true));
}

// At rest a machine costs the shop a report a second, however often its Interlock is
// written.
TEST_F(KnownService, ReportsWhatChangesAndElseOnceASecond) {
  bus::Reader<intaglio_MachineReport> reports(
      bus_, bus::kMachineReport, "", bus::Source::kEverybody, bus::Keeps::kEverySample);
  int count = 0;
  const auto take = [&] {
    count += reports.Take([](const intaglio_MachineReport&) {});
    return count;
  };
  auto now = std::chrono::nanoseconds(100s);
  for (int i = 0; i < 200; ++i) {
    intaglio_Interlock sample = InterlockOf(true);
    sample.state_age_ms = static_cast<std::uint32_t>(i % 20);
    reporter_.Update(sample);
    reporter_.Turn(now += 50ms);
  }
  reporter_.Update(InterlockOf(false));
  reporter_.Turn(now += 50ms);
  // In 10 s of 200 Interlocks, and for the door.
  constexpr int kReports = 10 + 1;
  EXPECT_TRUE(test::Eventually([&] { return take() >= kReports; }));
  EXPECT_EQ(take(), kReports);
}

}  // namespace
}  // namespace intaglio::job_service
