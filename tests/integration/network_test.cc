// Two computers: operator, job service and workers on one, the machine with its
// synchronizer and bridge on the other, and a cable between them that is cut, or loses
// what it carries. Cyclone's own traffic, encrypted, over TAP devices of two network
// namespaces; INTAGLIO_LONG=1 for the long cuts and the bad cables.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <iostream>
#include <thread>

#include "tests/integration/shop_floor.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::Cable;
using testing::DifferenceOf;
using testing::Eventually;
using testing::LongTests;
using testing::ShopFloor;
using testing::TestHost;
using Clock = std::chrono::steady_clock;

constexpr std::uint32_t kSeed = 20261121;
constexpr int kRateHz = 100;
constexpr char kDomain[] = "52";
// 2.4 to 3.3 s on a computer at rest (docs/measurements.md); identities that find one
// another anew take their time on a busy one.
constexpr double kResumeWithin_s = 15;

double Since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// How late this computer wakes a thread, at worst: what a machine's reaction may be late
/// by when other work is done beside the test.
class Lateness {
 public:
  double worst_s() const { return static_cast<double>(worst_us_) / 1e6; }

 private:
  std::atomic<std::int64_t> worst_us_ = 0;
  std::jthread thread_{[this](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      const auto begin = Clock::now();
      std::this_thread::sleep_for(1ms);
      const auto late = Clock::now() - begin - 1ms;
      const auto us = std::chrono::duration_cast<std::chrono::microseconds>(late).count();
      worst_us_ = std::max<std::int64_t>(worst_us_, us);
    }
  }};
};

class Network : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const std::string why = testing::WhyNoHosts(); !why.empty()) GTEST_SKIP() << why;
    ASSERT_FALSE(testing::UndisturbedPoints().empty());
    setenv("INTAGLIO_ALLOW_ROOT", "1", 1);
    office_ = std::make_unique<TestHost>("10.77.0.1");
    cell_ = std::make_unique<TestHost>("10.77.0.2");
    cable_ = std::make_unique<Cable>(*office_, *cell_, kSeed);
    std::cout << "  seed of the cable " << kSeed << "\n";
    const fs::path folder = test::FreshFolder();
    ShopFloor::Options options;
    options.bus = {"--domain",    kDomain, "--tag",      "network",
                   "--interface", "eth0",  "--security", Keys(folder).string()};
    options.office = office_.get();
    options.cell = cell_.get();
    floor_ = std::make_unique<ShopFloor>(folder, options);
  }

  /// Identities of all roles, in this folder.
  static fs::path Keys(const fs::path& folder) {
    testing::Running make(testing::Program("intaglio"),
                          {"security", "new", (folder / "keys").string(), "--domain",
                           kDomain, "--cell", "els-03"},
                          folder / "made.txt");
    EXPECT_EQ(make.WaitForEnd(60s).exit_code, 0) << make.Output();
    return folder / "keys";
  }

  bool Begin(std::int64_t cracks) {
    floor_->StartAll();
    return floor_->Engrave() && floor_->AwaitCracks(cracks, 40s);
  }

  struct Outage {
    double last_crack_s = 0;  ///< after the cut
    double late_s = 0;        ///< this computer, in the first second after it
    double resumed_s = -1;    ///< after the mending
  };

  /// Cuts the cable in mid-job, reconnects it, and lets the job come to its end.
  Outage Survive(bool a_to_b, bool b_to_a, std::chrono::milliseconds duration) {
    Outage outage;
    std::int64_t cut_tick = 0;
    if (!Begin(60)) {
      ADD_FAILURE() << "nothing is engraved\n" << floor_->Logs();
      return outage;
    }
    {
      const Lateness lateness;
      cable_->Cut(a_to_b, b_to_a);
      cut_tick = floor_->Panel("tick");
      std::this_thread::sleep_for(1s);
      outage.late_s = lateness.worst_s();
    }
    std::this_thread::sleep_for(duration - 1s);
    const std::int64_t restore_tick = floor_->Panel("tick");
    const std::int64_t before = floor_->Panel("cracks");
    cable_->Restore();
    const auto restored = Clock::now();
    if (floor_->AwaitCracks(before + 1, 60s)) outage.resumed_s = Since(restored);
    EXPECT_TRUE(floor_->Reaches("done", 60s)) << floor_->Logs();
    const auto cracks = floor_->Cracks();
    for (const auto& crack : cracks) {
      const auto tick = static_cast<std::int64_t>(crack.tick);
      if (tick > restore_tick) break;
      outage.last_crack_s = static_cast<double>(tick - cut_tick) / kRateHz;
    }
    EXPECT_EQ(DifferenceOf(cracks), "") << floor_->Logs();
    std::cout << "  cut for " << duration.count() << " ms: last crack "
              << outage.last_crack_s << " s after the cut (this computer is late by "
              << outage.late_s << " s), " << cracks.size() << " in all; first again "
              << outage.resumed_s << " s after the mending\n";
    return outage;
  }

  static void ExpectSafe(const Outage& outage, double bound_s) {
    EXPECT_LE(outage.last_crack_s, bound_s + outage.late_s);
    EXPECT_GE(outage.resumed_s, 0) << "it did not go on by itself";
    EXPECT_LE(outage.resumed_s, kResumeWithin_s + 10 * outage.late_s);
  }

  std::unique_ptr<TestHost> office_, cell_;
  std::unique_ptr<Cable> cable_;
  std::unique_ptr<ShopFloor> floor_;
};

TEST_F(Network, ACutOfASecondPausesAndTheJobGoesOn) {
  const Outage outage = Survive(true, true, 1s);
  ExpectSafe(outage, 0.30);
}

// The two of one direction go beyond the leases as well.
TEST_F(Network, ACutBeyondAllLeases) {
  if (!LongTests())
    GTEST_SKIP() << "takes minutes, the two below are alike: set INTAGLIO_LONG=1";
  const Outage outage = Survive(true, true, 5s);
  ExpectSafe(outage, 0.30);
}

TEST_F(Network, TheMachineReceivesFromNobody) {
  const Outage outage = Survive(true, false, 5s);
  ExpectSafe(outage, 0.30);
}

// The permission still comes, and so does an emergency stop: the machine goes on until
// the job service misses it, by the lease of its health.
TEST_F(Network, NobodyReceivesFromTheMachine) {
  if (!LongTests()) GTEST_SKIP() << "takes minutes: set INTAGLIO_LONG=1";
  const Outage outage = Survive(false, true, 5s);
  ExpectSafe(outage, 1.5 + 0.30);
}

TEST_F(Network, ACutWithinTheLimitOfAbsence) {
  if (!LongTests()) GTEST_SKIP() << "takes a minute: set INTAGLIO_LONG=1";
  const Outage outage = Survive(true, true, 20s);
  ExpectSafe(outage, 0.30);
}

// The block may have been changed meanwhile
// (services/platform/host/safety/absence_limit.h).
TEST_F(Network, ACutBeyondTheLimitOfAbsenceWaitsForAPerson) {
  if (!LongTests()) GTEST_SKIP() << "takes a minute: set INTAGLIO_LONG=1";
  ASSERT_TRUE(Begin(60)) << floor_->Logs();
  cable_->Cut(true, true);
  std::this_thread::sleep_for(40s);
  const std::int64_t cracks = floor_->Panel("cracks");
  cable_->Restore();
  ASSERT_TRUE(floor_->Opens()) << floor_->Logs();
  std::this_thread::sleep_for(10s);
  EXPECT_EQ(floor_->Panel("cracks"), cracks) << floor_->Logs();
  EXPECT_EQ(floor_->Newest("state"), "paused");
  floor_->Type({"resume", "1"});
  EXPECT_TRUE(floor_->Reaches("done", 60s)) << floor_->Logs();
  EXPECT_EQ(DifferenceOf(floor_->Cracks()), "") << floor_->Logs();
}

// From the first point to the end.
TEST_F(Network, WhatACableLosesCostsTimeOnly) {
  const std::vector<double> ratios =
      LongTests() ? std::vector{0.1, 0.0, 0.3} : std::vector{0.1};
  for (const double ratio : ratios) {
    if (ratio != ratios.front()) {
      TearDown();
      SetUp();
    }
    ASSERT_TRUE(Begin(1)) << floor_->Logs();
    const auto began = Clock::now();
    cable_->Lose(ratio);
    ASSERT_TRUE(floor_->Reaches("done", 90s)) << floor_->Logs();
    std::cout << "  " << 100 * ratio << " % lost: engraved in " << Since(began) << " s, "
              << cable_->carried() << " frames, " << cable_->lost() << " lost\n";
    EXPECT_EQ(DifferenceOf(floor_->Cracks()), "") << floor_->Logs();
  }
}

}  // namespace
}  // namespace intaglio
