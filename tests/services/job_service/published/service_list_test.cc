// Which services the job service lists, and from when on, by a clock of the test's own.

#include "services/job_service/published/service_list.h"

#include <gmock/gmock.h>

#include <optional>
#include <set>

#include "services/client/listed_services.h"
#include "services/platform/bus/role_names.h"
#include "services/platform/bus/samples.h"
#include "tests/services/platform/bus/private_bus.h"

namespace intaglio::job_service {
namespace {

using namespace std::chrono_literals;
using bus::Borrow;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

/// A service on a bus of its own; its health is written with the identity of its role.
class Service {
 public:
  Service(intaglio_ServiceRole role, const std::string& identity, const std::string& name,
          const std::string& cell = {})
      : bus_(test::PrivateBusOptions(cell, identity)),
        health_(bus_, bus::kServiceHealth, bus::RolePartition(identity)),
        instance_(name + "-" + bus_.participant_name()) {
    const std::string text;
    intaglio_ServiceHealth sample{};
    sample.instance = Borrow(instance_);
    sample.role = role;
    sample.cell = Borrow(cell);
    sample.state = intaglio_HEALTH_READY;
    sample.message = sample.host = sample.job_uid = sample.version = Borrow(text);
    EXPECT_TRUE(health_.Write(sample));
  }
  const std::string& instance() const { return instance_; }

 private:
  bus::Bus bus_;
  bus::Writer<intaglio_ServiceHealth> health_;
  std::string instance_;
};

class ServiceLists : public testing::Test {
 protected:
  std::set<std::string> Listed() {
    listed_.Poll();
    std::set<std::string> instances;
    const auto list = listed_.lists().find("job-service-1");
    if (list == listed_.lists().end()) return instances;
    for (const auto& service : list->second) instances.insert(service.instance);
    return instances;
  }
  /// Turns at this time until the list holds what is expected.
  bool Becomes(const std::set<std::string>& expected, std::chrono::nanoseconds now) {
    return test::Eventually(
        [&] {
          list_.Turn(now);
          return Listed() == expected;
        },
        20s);
  }

  bus::Bus bus_{test::PrivateBusOptions({}, bus::kJobServiceRole)};
  client::ListedServices listed_{bus_};
  ServiceList list_{bus_, "job-service-1"};
  std::chrono::nanoseconds start_ = 100s;
  std::chrono::nanoseconds discovered_ = start_ + bus_.discovery_time();
};

TEST_F(ServiceLists, NoneIsPublishedWhileAServiceCanStillBeUndiscovered) {
  const Service mill(intaglio_ROLE_MOTION_BRIDGE, bus::CellRole("mill"), "bridge",
                     "mill");
  list_.Turn(start_);
  const auto sampled_until = std::chrono::steady_clock::now() + 500ms;
  while (std::chrono::steady_clock::now() < sampled_until) {
    list_.Turn(discovered_ - 1ms);
    listed_.Poll();
    ASSERT_THAT(listed_.lists(), IsEmpty());
  }
  EXPECT_TRUE(Becomes({mill.instance()}, discovered_));
  EXPECT_THAT(listed_.Cells({intaglio_ROLE_MOTION_BRIDGE}), UnorderedElementsAre("mill"));
  EXPECT_THAT(listed_.Cells({intaglio_ROLE_SYNCHRONIZER}), IsEmpty());
}

TEST_F(ServiceLists, AServiceThatEndsLeavesIt) {
  const Service sorter(intaglio_ROLE_SORTER, bus::kStageWorkerRole, "sorter");
  std::optional<Service> mill;
  mill.emplace(intaglio_ROLE_MOTION_BRIDGE, bus::CellRole("mill"), "bridge", "mill");
  list_.Turn(start_);
  ASSERT_TRUE(Becomes({sorter.instance(), mill->instance()}, discovered_));
  mill.reset();
  EXPECT_TRUE(Becomes({sorter.instance()}, discovered_));
}

// Its instance names another process.
TEST_F(ServiceLists, AForgedHealthIsNotListed) {
  const Service sorter(intaglio_ROLE_SORTER, bus::kStageWorkerRole, "sorter");
  bus::Writer<intaglio_ServiceHealth> forger(bus_, bus::kServiceHealth,
                                             bus::RolePartition(bus::kStageWorkerRole));
  const std::string text, stolen = "bridge-" + std::string(24, '0');
  intaglio_ServiceHealth sample{};
  sample.instance = Borrow(stolen);
  sample.role = intaglio_ROLE_SORTER;
  sample.message = sample.host = sample.job_uid = sample.version = Borrow(text);
  sample.cell = Borrow(text);
  ASSERT_TRUE(forger.Write(sample));
  list_.Turn(start_);
  EXPECT_TRUE(Becomes({sorter.instance()}, discovered_));
}

}  // namespace
}  // namespace intaglio::job_service
