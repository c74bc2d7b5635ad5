#include "services/platform/host/peers/identity_role.h"

#include <gtest/gtest.h>

#include "services/platform/bus/role_names.h"
#include "services/platform/bus/samples.h"

namespace intaglio::host {
namespace {

using bus::Borrow;

constexpr char kParticipant[] = "0110aabbccddeeff00112233";
constexpr char kOther[] = "0110aabbccddeeff00112234";

struct Health {
  std::string instance, cell;
  intaglio_ServiceRole role;
  intaglio_ServiceHealth sample() const {
    intaglio_ServiceHealth health{};
    health.instance = Borrow(instance);
    health.cell = Borrow(cell);
    health.role = role;
    return health;
  }
};

Health HealthOf(const std::string& service, intaglio_ServiceRole role,
                const std::string& cell = "") {
  return {InstanceName(service, "host", 12, kParticipant), cell, role};
}

bool Counts(const Health& health, const std::string& role,
            const std::string& participant = kParticipant) {
  const bus::SampleWriter writer{participant, bus::RolePartition(role)};
  return IsOwnHealth(health.sample(), {true, 0, false, &writer});
}

TEST(IdentityRole, HealthCountsFromTheProcessAndTheRoleThatItNames) {
  const Health sorter = HealthOf("sorter", intaglio_ROLE_SORTER);
  EXPECT_TRUE(Counts(sorter, "stage-worker"));
  EXPECT_FALSE(Counts(sorter, "stage-worker", kOther));
  EXPECT_FALSE(Counts(sorter, "recorder"));
  const Health cell = HealthOf("synchronizer", intaglio_ROLE_SYNCHRONIZER, "els-03");
  EXPECT_TRUE(Counts(cell, "cell-els-03"));
  EXPECT_FALSE(Counts(cell, "cell-els-04"));
  EXPECT_FALSE(Counts(cell, "stage-worker"));
  const Health jobs = HealthOf("job-service", intaglio_ROLE_JOB_SERVICE);
  EXPECT_TRUE(Counts(jobs, "job-service"));
  EXPECT_FALSE(Counts(jobs, "cell-els-03"));
}

// A cell whose name is chosen to resemble a role's partition.
TEST(IdentityRole, ACellNamedAfterARoleIsNotThatRole) {
  EXPECT_NE(bus::RolePartition(bus::CellRole("x")), bus::RolePartition("stage-worker"));
  EXPECT_FALSE(Counts(HealthOf("sorter", intaglio_ROLE_SORTER), "cell-stage-worker"));
}

// An identity has one of several partitions; a list of them is no role.
TEST(IdentityRole, SeveralPartitionsAreNoRole) {
  EXPECT_FALSE(Counts(HealthOf("sorter", intaglio_ROLE_SORTER), "stage-worker,role/x"));
}

TEST(IdentityRole, AWriterThatIsNotKnownIsNotBelieved) {
  const Health sorter = HealthOf("sorter", intaglio_ROLE_SORTER);
  EXPECT_FALSE(IsOwnHealth(sorter.sample(), {true, 0, false, nullptr}));
}

TEST(IdentityRole, AnInstanceIsEndedByItselfOrByItsLostLease) {
  const Health sorter = HealthOf("sorter", intaglio_ROLE_SORTER);
  const bus::SampleWriter self{kParticipant, "role/stage-worker"};
  const bus::SampleWriter other{kOther, "role/stage-worker"};
  EXPECT_TRUE(IsOwnHealth(sorter.sample(), {false, 0, true, &self}));
  EXPECT_FALSE(IsOwnHealth(sorter.sample(), {false, 0, true, &other}));
  EXPECT_TRUE(IsOwnHealth(sorter.sample(), {false, 0, false, &other}));
}

TEST(IdentityRole, ATaskCountsFromItsWorkerAndTheRoleOfItsStage) {
  const auto counts = [](intaglio_Stage stage, const std::string& role,
                         const std::string& participant = kParticipant) {
    const std::string worker = InstanceName("worker", "host", 12, kParticipant);
    intaglio_TaskStatus status{};
    status.worker = Borrow(worker);
    status.stage = stage;
    const bus::SampleWriter writer{participant, bus::RolePartition(role)};
    return IsOwnTask(status, {true, 0, false, &writer});
  };
  EXPECT_TRUE(counts(intaglio_STAGE_SORT, "stage-worker"));
  EXPECT_TRUE(counts(intaglio_STAGE_DISCRETIZE, "stage-worker"));
  EXPECT_TRUE(counts(intaglio_STAGE_ENGRAVE, "cell-els-03"));
  EXPECT_FALSE(counts(intaglio_STAGE_ENGRAVE, "stage-worker"));
  EXPECT_FALSE(counts(intaglio_STAGE_SORT, "cell-els-03"));
  EXPECT_FALSE(counts(intaglio_STAGE_SORT, "stage-worker", kOther));
  EXPECT_FALSE(counts(intaglio_STAGE_ENGRAVE, "cell-els-03", kOther));
}

}  // namespace
}  // namespace intaglio::host
