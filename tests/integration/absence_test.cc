// Absences of one part of a machine's supervision are added up: 25 s away, back until the
// job fires again by itself, 25 s away, and nothing fires any more without a person.
// Four parts at once, each in a shop of its own, by the clock.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <memory>
#include <thread>
#include <vector>

#include "tests/integration/shop_floor.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

using namespace std::chrono_literals;
using testing::AskPanel;
using testing::Ended;
using testing::Eventually;
using testing::ShopFloor;

constexpr auto kAway = 25s;
// Behind a lost line a job goes on within three seconds.
constexpr auto kGoesOn = 20s, kStaysDark = 8s;

/// A part of the supervision that comes and goes.
struct Part {
  const char* name;
  void (*goes)(ShopFloor& floor);
  void (*comes)(ShopFloor& floor);
};

template <const char* const& kService>
constexpr Part Process(const char* name) {
  return {name, [](ShopFloor& floor) { floor.at(kService).Signal(SIGKILL); },
          [](ShopFloor& floor) { floor.Start(kService); }};
}

const std::vector<Part> kParts = {
    {"the laser's line",
     [](ShopFloor& floor) { AskPanel(floor.folder(), "unplug laser"); },
     [](ShopFloor& floor) { AskPanel(floor.folder(), "plug laser"); }},
    {"the stage's line",
     [](ShopFloor& floor) { AskPanel(floor.folder(), "unplug motion"); },
     [](ShopFloor& floor) { AskPanel(floor.folder(), "plug motion"); }},
    Process<testing::kSynchronizer>("the synchronizer"),
    Process<testing::kJobService>("the job service"),
};

/// A shop whose job has begun to fire.
class AwayShop {
 public:
  AwayShop(const Part& part, std::size_t number)
      : part_(part),
        floor_(test::FreshFolder("Absence/" + std::to_string(number)),
               OptionsOf(number)) {
    floor_.StartAll();
    // Longer than the test.
    job_ = floor_.Engrave({"--height", "4.2", "--spacing", "0.5", "--rate", "2"})
               .value_or("");
  }
  bool Fires(std::chrono::milliseconds bound) {
    const std::size_t before = floor_.Cracks().size();
    return Eventually([&] { return floor_.Cracks().size() > before + 3; }, bound);
  }
  void Goes() { part_.goes(floor_); }
  void Comes() { part_.comes(floor_); }
  std::size_t Cracks() const { return floor_.Cracks().size(); }
  std::string Show() { return floor_.Type({"show", job_}).output; }
  Ended Resume() { return floor_.Type({"resume", job_}); }
  std::size_t Doubled() const {
    auto cracks = floor_.Cracks();
    std::size_t doubled = 0;
    for (std::size_t i = 0; i < cracks.size(); ++i) {
      for (std::size_t k = 0; k < i; ++k)
        doubled += (cracks[i].position_mm - cracks[k].position_mm).norm() < 0.03;
    }
    return doubled;
  }

 private:
  static ShopFloor::Options OptionsOf(std::size_t number) {
    ShopFloor::Options options;
    options.bus = {"--domain", "55", "--tag",
                   "away" + std::to_string(getpid()) + "n" + std::to_string(number)};
    return options;
  }
  const Part& part_;
  ShopFloor floor_;
  std::string job_;
};

TEST(Absence, TwoThatAreTooLongTogetherNeedAPerson) {
  std::vector<std::unique_ptr<AwayShop>> shops;
  for (std::size_t i = 0; i < kParts.size(); ++i)
    shops.push_back(std::make_unique<AwayShop>(kParts[i], i));
  for (const auto& shop : shops) ASSERT_TRUE(shop->Fires(40s)) << shop->Show();
  for (const auto& shop : shops) shop->Goes();
  std::this_thread::sleep_for(kAway);
  for (const auto& shop : shops) shop->Comes();
  for (const auto& shop : shops)
    ASSERT_TRUE(shop->Fires(kGoesOn)) << "not by itself: " << shop->Show();
  for (const auto& shop : shops) shop->Goes();
  std::this_thread::sleep_for(kAway);
  std::vector<std::size_t> dark;
  for (const auto& shop : shops) dark.push_back(shop->Cracks());
  for (const auto& shop : shops) shop->Comes();
  std::this_thread::sleep_for(kStaysDark);
  for (std::size_t i = 0; i < shops.size(); ++i) {
    EXPECT_EQ(shops[i]->Cracks(), dark[i]) << "it fires by itself: " << shops[i]->Show();
    EXPECT_THAT(shops[i]->Show(), ::testing::HasSubstr("state      paused"))
        << kParts[i].name;
  }
  for (const auto& shop : shops) {
    const Ended resumed = shop->Resume();
    EXPECT_EQ(resumed.exit_code, 0) << resumed.output << shop->Show();
    EXPECT_TRUE(shop->Fires(90s)) << shop->Show();
    EXPECT_EQ(shop->Doubled(), 0u);
  }
}

}  // namespace
}  // namespace intaglio
