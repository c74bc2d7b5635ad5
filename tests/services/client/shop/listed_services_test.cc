// A client that has just joined waits for the services that the job service lists, and no
// longer; the test plays them.

#include "services/client/listed_services.h"

#include <gmock/gmock.h>

#include <memory>
#include <thread>

#include "services/client/job_client.h"
#include "services/client/shop/shop_stops.h"
#include "services/client/teach_client.h"
#include "services/platform/bus/samples.h"
#include "tests/services/platform/bus/private_bus.h"

namespace intaglio::client {
namespace {

using namespace std::chrono_literals;
using bus::Borrow;
using ::testing::HasSubstr;
using Clock = std::chrono::steady_clock;

class Listed : public ::testing::Test {
 protected:
  void Health(const std::string& instance, intaglio_ServiceRole role,
              const std::string& cell = {}) {
    const std::string text;
    intaglio_ServiceHealth sample{};
    sample.instance = Borrow(instance);
    sample.role = role;
    sample.state = intaglio_HEALTH_READY;
    sample.cell = Borrow(cell);
    sample.message = sample.host = sample.job_uid = sample.version = Borrow(text);
    EXPECT_TRUE(health_.Write(sample));
  }
  void List(const std::vector<ListedService>& services) {
    std::vector<intaglio_ServiceEntry> entries;
    for (const ListedService& service : services)
      entries.push_back({Borrow(service.instance), service.role, Borrow(service.cell)});
    intaglio_ServiceList sample{};
    const std::string instance = "job-service-1";
    sample.instance = Borrow(instance);
    Borrow(sample.services, entries);
    EXPECT_TRUE(lists_.Write(sample));
  }
  void State(const std::string& cell, double place = 0) {
    const std::string text;
    intaglio_ManualState sample{};
    sample.cell = Borrow(cell);
    sample.held_by = sample.refusal = sample.axes = sample.profile = Borrow(text);
    sample.answered_sender = sample.message = Borrow(text);
    sample.position[0] = place;
    states_.push_back(std::make_unique<bus::Writer<intaglio_ManualState>>(
        bus_, bus::kManualState, cell));
    EXPECT_TRUE(states_.back()->Write(sample));
  }

  bus::Bus bus_{test::PrivateBusOptions()};
  bus::Writer<intaglio_ServiceHealth> health_{bus_, bus::kServiceHealth};
  bus::Writer<intaglio_ServiceList> lists_{bus_, bus::kServiceList};
  std::vector<std::unique_ptr<bus::Writer<intaglio_ManualState>>> states_;
};

TEST_F(Listed, AClientKnowsAllServicesWhenEachOfTheListHasCome) {
  JobClient client(bus_);
  const auto knows = [&] { return client.KnowsAllServices(client.services()); };
  Health("job-service-1", intaglio_ROLE_JOB_SERVICE);
  EXPECT_FALSE(client.PollUntil(knows, 300ms)) << "nothing is listed yet";
  List({{"job-service-1", intaglio_ROLE_JOB_SERVICE, ""},
        {"sorter-1", intaglio_ROLE_SORTER, ""}});
  EXPECT_FALSE(client.PollUntil(knows, 300ms)) << "the sorter has not come";
  Health("sorter-1", intaglio_ROLE_SORTER);
  EXPECT_TRUE(client.PollUntil(knows, 20s));
}

TEST_F(Listed, WithoutAJobServiceAClientNeverKnowsAll) {
  JobClient client(bus_);
  Health("sorter-1", intaglio_ROLE_SORTER);
  EXPECT_FALSE(client.PollUntil(
      [&] { return client.KnowsAllServices(client.services()); }, 300ms));
}

// A table of two turns is on its way for longer than its travel in rad makes one expect.
TEST_F(Listed, AMachineThatMovesIsWaitedFor) {
  TeachClient client(bus_, "polar");
  const auto begun = Clock::now();
  std::jthread machine([this, begun] {
    for (double place = 0; Clock::now() < begun + 3s; place += 0.1) {
      State("polar", place);
      std::this_thread::sleep_for(100ms);
    }
  });
  const auto answer = client.Execute({}, 1500ms, {});
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().code, ErrorCode::kTimedOut);
  EXPECT_GT(Clock::now() - begun, 4s) << "it was given up while it moved";
}

TEST_F(Listed, TheOnlyMachineThatIsListedIsFound) {
  List({{"bridge-1", intaglio_ROLE_MOTION_BRIDGE, "mill"}});
  State("mill");
  const auto found = TeachClient::FindMachine(bus_, "");
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(*found, "mill");
}

// A jog of the wrong machine would be the harm.
TEST_F(Listed, AMachineThatIsListedIsWaitedForBeforeAnotherOneIsTheOnlyOne) {
  List({{"bridge-1", intaglio_ROLE_MOTION_BRIDGE, "mill"},
        {"bridge-2", intaglio_ROLE_MOTION_BRIDGE, "els-03"}});
  State("mill");
  const auto begin = Clock::now();
  std::jthread late([&] {
    std::this_thread::sleep_for(400ms);
    State("els-03");
  });
  const auto found = TeachClient::FindMachine(bus_, "");
  EXPECT_GE(Clock::now() - begin, 400ms);
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().message, HasSubstr("several machines found (els-03, mill)"));
}

// A mill is moved by its marker, which has the role of a synchronizer.
TEST_F(Listed, AListedMillIsWaitedForBeforeAnEngraverIsTheOnlyMachine) {
  List({{"marker-1", intaglio_ROLE_SYNCHRONIZER, "mill"},
        {"bridge-2", intaglio_ROLE_MOTION_BRIDGE, "els-03"}});
  State("els-03");
  std::jthread late([&] {
    std::this_thread::sleep_for(400ms);
    State("mill");
  });
  const auto found = TeachClient::FindMachine(bus_, "");
  ASSERT_FALSE(found) << *found << " would have been moved";
  EXPECT_THAT(found.error().message, HasSubstr("several machines found (els-03, mill)"));
}

TEST_F(Listed, MachinesToResetAreKnownWhenEachOfTheListHasCome) {
  MachineReports reports(bus_, "");
  List({{"bridge-1", intaglio_ROLE_MOTION_BRIDGE, "mill"},
        {"synchronizer-2", intaglio_ROLE_SYNCHRONIZER, "els-03"}});
  Health("bridge-1", intaglio_ROLE_MOTION_BRIDGE, "mill");
  const auto knows = [&] {
    reports.Poll();
    return reports.KnowsAllMachines();
  };
  ASSERT_TRUE(test::Eventually([&] { return reports.Poll().contains("mill"); }, 20s));
  EXPECT_FALSE(knows());
  Health("synchronizer-2", intaglio_ROLE_SYNCHRONIZER, "els-03");
  EXPECT_TRUE(test::Eventually(knows, 20s));
}

}  // namespace
}  // namespace intaglio::client
