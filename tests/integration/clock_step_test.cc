// The wall clock of one computer, or of one process, is set by an hour in mid-job.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <iostream>

#include "tests/integration/shop_floor.h"
#include "tests/test_folder.h"
#include "tests/test_name.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::DifferenceOf;
using testing::ShopFloor;

constexpr long kHour = 3600;

class ClockStep : public ::testing::TestWithParam<std::pair<const char*, long>> {
 protected:
  ClockStep() : folder_(test::FreshFolder()) {}

  void Set(const std::string& service, long seconds) const {
    std::fstream file(folder_ / (service + ".offset"),
                      std::ios::binary | std::ios::in | std::ios::out);
    file.write(reinterpret_cast<const char*>(&seconds), sizeof seconds);
  }

  fs::path folder_;
};

TEST_P(ClockStep, OfOneServiceCostsNothing) {
  const auto [stepped, seconds] = GetParam();
  if (stepped != std::string("all") && !testing::LongTests()) {
    GTEST_SKIP() << "takes minutes, all at once is tested: set INTAGLIO_LONG=1";
  }
  ASSERT_FALSE(testing::UndisturbedPoints().empty());
  ShopFloor::Options options;
  options.bus = {"--domain", "54", "--tag", "clock" + std::to_string(getpid())};
  ShopFloor floor(folder_, options);
  floor.StartMachine();
  const std::vector<std::string> services = {testing::kJobService, testing::kDiscretizer,
                                             testing::kSorter, testing::kBridge,
                                             testing::kSynchronizer};
  for (const std::string& service : services) {
    const fs::path file = folder_ / (service + ".offset");
    std::ofstream(file, std::ios::binary).write("\0\0\0\0\0\0\0\0", 8);
    floor.Start(service, {{"LD_PRELOAD", INTAGLIO_CLOCK_SHIM},
                          {"INTAGLIO_CLOCK_OFFSET", file.string()}});
  }
  ASSERT_TRUE(floor.Engrave()) << floor.Logs();
  ASSERT_TRUE(floor.AwaitCracks(60, 40s)) << floor.Logs();
  for (const std::string& service : services) {
    if (std::string(stepped) == "all" || service == stepped) Set(service, seconds);
  }
  const auto set_at = std::chrono::steady_clock::now();
  EXPECT_TRUE(floor.Reaches("done", 60s)) << floor.Logs();
  std::cout
      << "  done "
      << std::chrono::duration<double>(std::chrono::steady_clock::now() - set_at).count()
      << " s after the step\n";
  EXPECT_EQ(DifferenceOf(floor.Cracks()), "") << floor.Logs();
  // Half a second of warm-up and 3.5 s of machining, and no hour in any figure.
  const std::string events = floor.Events();
  const auto at = events.rfind("\"elapsed_s\":");
  ASSERT_NE(at, std::string::npos);
  const double elapsed_s = std::stod(events.substr(at + 12));
  EXPECT_GE(elapsed_s, 0);
  EXPECT_LT(elapsed_s, 100);
}

INSTANTIATE_TEST_SUITE_P(Hours, ClockStep,
                         ::testing::Values(std::pair{testing::kJobService, -kHour},
                                           std::pair{testing::kJobService, kHour},
                                           std::pair{testing::kSynchronizer, -kHour},
                                           std::pair{testing::kSynchronizer, kHour},
                                           std::pair{testing::kBridge, -kHour},
                                           std::pair{"all", -kHour},
                                           std::pair{"all", kHour}),
                         [](const auto& row) {
                           return test::AsTestName(row.param.first) +
                                  (row.param.second < 0 ? "_back" : "_forward");
                         });

}  // namespace
}  // namespace intaglio
