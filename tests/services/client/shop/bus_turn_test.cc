#include "services/client/shop/bus_turn.h"

#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <optional>
#include <thread>
#include <vector>

#include "tests/test_folder.h"

namespace intaglio::client {
namespace {

using namespace std::chrono_literals;

TEST(BusTurn, GivesAsManyPlacesAsThereAreAndNoMore) {
  const auto folder = test::FreshFolder();
  std::vector<BusTurn> taken;
  for (std::size_t i = 0; i < BusTurn::kPlaces; ++i) {
    taken.emplace_back(folder, 0ms);
    EXPECT_TRUE(taken.back().has_place()) << i;
  }
  EXPECT_FALSE(BusTurn(folder, 0ms).has_place());
  taken[2].End();
  EXPECT_TRUE(BusTurn(folder, 0ms).has_place());
}

TEST(BusTurn, GoesOnWithoutAPlaceWhenNoneIsGivenBack) {
  const auto folder = test::FreshFolder();
  std::vector<BusTurn> taken;
  for (std::size_t i = 0; i < BusTurn::kPlaces; ++i) taken.emplace_back(folder);
  const auto began = std::chrono::steady_clock::now();
  EXPECT_FALSE(BusTurn(folder, 100ms).has_place());
  EXPECT_GE(std::chrono::steady_clock::now() - began, 100ms);
}

TEST(BusTurn, NeedsNoFolderThatCanBeWritten) {
  const auto file = test::FreshFolder() / "file";
  std::ofstream(file) << "no folder";
  EXPECT_FALSE(BusTurn(file / "below").has_place()) << "and does not wait for one";
}

TEST(BusTurn, ServesAllWhoWait) {
  const auto folder = test::FreshFolder();
  std::atomic<std::size_t> inside = 0, peak = 0, served = 0;
  {
    std::vector<std::jthread> clients;
    for (int i = 0; i < 40; ++i) {
      clients.emplace_back([&] {
        const BusTurn turn(folder);
        const std::size_t now = ++inside;
        for (std::size_t seen = peak; seen < now;) peak.compare_exchange_weak(seen, now);
        std::this_thread::sleep_for(2ms);
        --inside;
        if (turn.has_place()) ++served;
      });
    }
  }
  EXPECT_EQ(served, 40);
  EXPECT_LE(peak, BusTurn::kPlaces);
}

}  // namespace
}  // namespace intaglio::client
