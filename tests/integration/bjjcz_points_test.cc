// Points in glass through all processes at a virtual BJJCZ board, whose own record is the
// judge. Its places become places in the glass by a ray trace of the tests' own.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/integration/bjjcz_glass.h"
#include "tests/integration/point_shop.h"

namespace intaglio {
namespace {

using namespace std::chrono_literals;
using testing::Eventually;

constexpr double kAxisStepsPerMm = 400, kZStepMm = 0.066;
constexpr std::size_t kListPoints = 32;
constexpr int kPulses = 21;  // of a point; the profile's dwell has 15

std::vector<std::pair<std::string, std::string>> OtherLines(bool slow) {
  if (!slow) return {};
  return {{"    dwell_s", "    dwell_s: 0.02"}};
}

class BoardPoints : public ::testing::Test {
 protected:
  explicit BoardPoints(bool on_usb = false, std::vector<std::string> new_options = {},
                       double field_mm = testing::kBoardFieldMm)
      : field_mm_(field_mm),
        shop_({.controller = "bjjcz",
               .profile = "bjjcz-glass",
               .controller_options = {"--axis", "400"},
               .new_options = std::move(new_options),
               .other_lines = OtherLines(on_usb),
               .on_usb = on_usb,
               .has_panel = true,
               .job = testing::KnotOf(6, 0.3) + "laser { photosensor_feedback: false" +
                      (on_usb ? "" : fmt::format(" pulses_per_point: {}", kPulses)) +
                      " }\n"}) {}
  void SetUp() override {
    ASSERT_TRUE(shop_.Open()) << shop_.Log();
    ASSERT_TRUE(shop_.Submit());
  }

  void AtPanel(const std::string& command) const {
    EXPECT_EQ(testing::AskPanel(shop_.folder(), command), "ok\n") << command;
  }
  /// In the glass, in the order in which the board made them. `pulses`: of each.
  PointList Flashes(std::vector<int>* pulses_of_each = nullptr) const {
    PointList made_mm;
    std::ifstream record(shop_.record());
    for (std::string line; std::getline(record, line);) {
      std::istringstream in(line);
      std::string kind;
      double x = 0, y = 0, axis = 0, begin_us = 0, lit_us = 0;
      int pulses = 0;
      if (!(in >> kind >> x >> y >> axis >> begin_us >> lit_us >> pulses) ||
          kind != "flash")
        continue;
      if (pulses_of_each) pulses_of_each->push_back(pulses);
      made_mm.push_back(
          testing::FocusInGlass(Vec2(x - 32768, y - 32768) * field_mm_ / 65536,
                                testing::kBlockHeightMm - (axis / kAxisStepsPerMm - 1)));
    }
    return made_mm;
  }

  struct Judgement {
    std::size_t points = 0, flashes = 0, doubled = 0, stray = 0, missing = 0,
                uncertain = 0, made_unknown = 0;
    double beside_um = 0, above_um = 0;  ///< the farthest
  };
  Judgement Judge() const;

  double field_mm_;
  testing::PointShop shop_;
};

// A flash belongs to the nearest point.
BoardPoints::Judgement BoardPoints::Judge() const {
  Judgement judgement;
  const testing::PointShop::Points job = shop_.PointsOfJob();
  EXPECT_FALSE(job.at_mm.empty());
  judgement.points = job.at_mm.size();
  std::vector<int> made(judgement.points, 0);
  for (const Vec3& flash : Flashes()) {
    ++judgement.flashes;
    std::size_t nearest = 0;
    for (std::size_t i = 0; i < judgement.points; ++i) {
      if ((job.at_mm[i] - flash).norm() < (job.at_mm[nearest] - flash).norm())
        nearest = i;
    }
    const Vec3 by_um = 1000 * (flash - job.at_mm[nearest]);
    judgement.stray += by_um.norm() > 100;
    judgement.beside_um = std::max(judgement.beside_um, by_um.head<2>().norm());
    judgement.above_um = std::max(judgement.above_um, std::abs(by_um.z()));
    judgement.doubled += ++made[nearest] > 1;
  }
  for (std::size_t i = 0; i < job.last.size(); ++i) {
    const bool uncertain = job.last[i] == formats::PointOutcome::kUncertain;
    judgement.uncertain += uncertain;
    judgement.missing += !uncertain && made[i] == 0;
    judgement.made_unknown += job.last[i] == formats::PointOutcome::kNone;
  }
  return judgement;
}

TEST_F(BoardPoints, EachIsMadeOnceAndInItsPlace) {
  ASSERT_TRUE(shop_.AwaitDone(240s, false)) << shop_.shown();
  const Judgement judgement = Judge();
  EXPECT_GT(judgement.points, 300U);
  EXPECT_EQ(judgement.flashes, judgement.points);
  EXPECT_EQ(judgement.doubled + judgement.stray + judgement.missing +
                judgement.uncertain + judgement.made_unknown,
            0U);
  std::vector<int> pulses;
  ASSERT_EQ(Flashes(&pulses).size(), judgement.points);
  EXPECT_THAT(pulses, ::testing::Each(kPulses));
  // Half a place of the board on both axes is 1.2 um.
  EXPECT_LT(judgement.beside_um, 2.5);
  // Half a step of z in the glass, its own steps, and the spherical aberration.
  EXPECT_LT(judgement.above_um,
            1000 * (kZStepMm / 2 + 0.5 / kAxisStepsPerMm) * testing::kBoardIndex + 10);
  std::cout << "  " << judgement.points << " points, " << judgement.beside_um
            << " um beside, " << judgement.above_um << " um above or below\n";
}

// A profile that `intaglio machine new` made from a device of LightBurn. At that device a
// mm is 65536 / 110 * 0.98 units of the board.
class BoardPointsOfADevice : public BoardPoints {
 protected:
  BoardPointsOfADevice()
      : BoardPoints(false,
                    {"--from", INTAGLIO_SOURCE_DIR "/tests/data/devices/galvo.lbzip"},
                    testing::kBoardFieldMm / 0.98) {}
};

TEST_F(BoardPointsOfADevice, EachIsMadeOnceAndInItsPlace) {
  ASSERT_TRUE(shop_.AwaitDone(240s, false)) << shop_.shown();
  const Judgement judgement = Judge();
  EXPECT_GT(judgement.points, 300U);
  EXPECT_EQ(judgement.flashes, judgement.points);
  EXPECT_EQ(judgement.doubled + judgement.stray + judgement.missing +
                judgement.uncertain + judgement.made_unknown,
            0U);
  EXPECT_LT(judgement.beside_um, 2.5);
}

// On USB, behind tests/services/platform/link/fake_libusb.cc as the programs' library. A
// point takes 20 ms here, so that no fault comes behind the last one.
class BoardPointsOnUsb : public BoardPoints {
 protected:
  BoardPointsOnUsb() : BoardPoints(true) {}
  /// The job is resumed where it waits for it.
  bool AwaitGrowth(std::size_t count) {
    const std::size_t before = Flashes().size();
    return Eventually(
        [&] {
          const auto grows = [&] { return Flashes().size() >= before + count; };
          return Eventually(grows, 2s) || (shop_.AwaitDone(0s, true), false);
        },
        90s);
  }
  struct Fault {
    std::string name;
    std::function<bool()> inflict;
  };
  Fault Death(const std::string& service) {
    return {service, [this, service] { return shop_.Kill(service) > 0; }};
  }
  Fault ForAWhile(const std::string& name, const std::function<void(bool)>& set) {
    return {name, [set] {
              set(true);
              std::this_thread::sleep_for(1s);
              set(false);
              return true;
            }};
  }
  bool Types(const std::vector<std::string>& words) const {
    return shop_.Type(words).find("error") == std::string::npos;
  }
  std::vector<Fault> Faults();
};

std::vector<BoardPointsOnUsb::Fault> BoardPointsOnUsb::Faults() {
  const auto plug = shop_.folder() / "usb/1-2.3", pulled = shop_.folder() / "pulled";
  const auto home = [this] {
    AtPanel("power off");
    std::this_thread::sleep_for(1s);
    AtPanel("power on");
    return Eventually(
        [this] {
          return shop_.Type({"teach", "home"}).starts_with("x ");
        },
        60s);
  };
  return {
      {"pause",
       [this] {
         return Types({"pause", "1"});
       }},
      {"stop",
       [this] {
         (void)shop_.Type({"stop"});
         std::this_thread::sleep_for(300ms);
         return Types({"stop", "--reset"});
       }},
      Death("intaglio-synchronizer"),
      Death("intaglio-motion-bridge"),
      ForAWhile("cable",
                [plug, pulled](bool cut) {
                  std::filesystem::rename(cut ? plug : pulled, cut ? pulled : plug);
                }),
      Death("intaglio-job-service"),
      ForAWhile("door",
                [this](bool open) { AtPanel(open ? "door open" : "door close"); }),
      Death("intaglio-sorter"),
      Death("intaglio-discretizer"),
      {"power", home},
  };
}

TEST_F(BoardPointsOnUsb, AtTenInstantsNoPointIsDoubledOrMissingAndAListIsUncertain) {
  std::size_t uncertain = 0, inflicted = 0;
  for (const Fault& fault : Faults()) {
    ASSERT_TRUE(AwaitGrowth(40)) << "before " << fault.name << ": " << shop_.shown();
    ASSERT_TRUE(fault.inflict()) << fault.name;
    ++inflicted;
    // More than the list that the board may have had: what became of it is known.
    ASSERT_TRUE(AwaitGrowth(kListPoints + 8))
        << "behind " << fault.name << ": " << shop_.shown();
    const Judgement now = Judge();
    EXPECT_EQ(now.doubled + now.stray, 0U) << fault.name;
    EXPECT_LE(now.uncertain - uncertain, kListPoints) << fault.name;
    std::cout << "  " << fault.name << ": " << now.uncertain - uncertain
              << " uncertain\n";
    uncertain = now.uncertain;
  }
  EXPECT_EQ(inflicted, 10U);
  ASSERT_TRUE(shop_.AwaitDone(240s, true)) << shop_.shown();
  const Judgement judgement = Judge();
  EXPECT_EQ(
      judgement.doubled + judgement.stray + judgement.missing + judgement.made_unknown,
      0U);
  EXPECT_GT(judgement.uncertain, 0U) << "no fault came into a list";
  std::cout << "  " << judgement.points << " points, " << judgement.flashes << " made, "
            << judgement.uncertain << " uncertain\n";
}

// The axis has lost its place: nothing is made before a person has homed it.
TEST_F(BoardPoints, APowerCycleWaitsForAPerson) {
  ASSERT_TRUE(Eventually([&] { return Flashes().size() > 60; }, 60s));
  AtPanel("power off");
  std::this_thread::sleep_for(1s);
  const std::size_t made = Flashes().size();
  AtPanel("power on");
  (void)shop_.AwaitDone(8s, true);
  EXPECT_EQ(Flashes().size(), made) << "made before it was homed";
  std::string homed = "not begun";
  ASSERT_TRUE(Eventually(
      [&] {
        homed = shop_.Type({"teach", "home"});
        return homed.starts_with("x ");
      },
      60s))
      << homed;
  ASSERT_TRUE(shop_.AwaitDone(240s, true)) << shop_.shown();
  const Judgement judgement = Judge();
  EXPECT_EQ(
      judgement.doubled + judgement.stray + judgement.missing + judgement.made_unknown,
      0U);
  EXPECT_LE(judgement.uncertain, kListPoints);
  std::cout << "  " << judgement.points << " points, " << judgement.uncertain
            << " uncertain\n";
}

}  // namespace
}  // namespace intaglio
