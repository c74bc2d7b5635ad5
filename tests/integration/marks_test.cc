// Jobs of marks through all processes of a shop whose machine is the virtual scan head.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <random>
#include <set>
#include <thread>

#include "engrave/formats/mark_record.h"
#include "engrave/mark/mark_file.h"
#include "engrave/render/canvas.h"
#include "engrave/render/png_file.h"
#include "tests/integration/mark_shop.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::Eventually;
using ::testing::HasSubstr;
using testing::MarkJudgement;
using testing::MarkShop;
using testing::Program;
using testing::Running;

constexpr std::size_t kMarks = 200;
constexpr auto kBound = 150s;

/// 200 circles on a piece at rest, four seconds of marking.
MarkShop::Options CirclesAtRest() {
  return {.job =
              "name: \"circles\" marks { items { drawing { file: \"circles.svg\" } } "
              "pen { speed_mm_s: 200 power_ratio: 0.5 } }",
          .mark_count = kMarks};
}

fs::path FolderWithCircles(const std::string& name = "") {
  fs::path folder = test::FreshFolder();
  if (!name.empty()) fs::create_directory(folder /= name);
  std::ofstream(folder / "circles.svg") << testing::CirclesSvg(kMarks);
  return folder;
}

TEST(MarkShopTest, MakesEachMarkOnce) {
  MarkShop shop(CirclesAtRest(), FolderWithCircles());
  ASSERT_TRUE(shop.Open()) << shop.UpOutput();
  ASSERT_TRUE(shop.Submit());
  ASSERT_TRUE(shop.AwaitDone(kBound)) << shop.shown() << shop.UpOutput();
  const MarkJudgement judgement = shop.Judge();
  EXPECT_EQ(judgement.burnt, kMarks);
  EXPECT_EQ(judgement.doubled, 0u);
  EXPECT_EQ(judgement.unknown + judgement.not_made, 0u);
  // A computer that is busy for 250 ms ends the beam in mid-mark, as it should.
  EXPECT_EQ(judgement.made + judgement.uncertain, kMarks);
}

TEST(MarkShopTest, APauseEndsTheMarkInHand) {
  MarkShop shop(CirclesAtRest(), FolderWithCircles());
  ASSERT_TRUE(shop.Open()) << shop.UpOutput();
  ASSERT_TRUE(shop.Submit());
  ASSERT_TRUE(Eventually([&] { return shop.BurntTicks() > 5000; }, 60s));
  shop.Type({"pause", "1"});
  ASSERT_TRUE(shop.AwaitDone(kBound)) << shop.shown() << shop.UpOutput();
  const MarkJudgement judgement = shop.Judge();
  EXPECT_EQ(judgement.burnt, kMarks);
  EXPECT_EQ(judgement.doubled + judgement.unknown + judgement.not_made, 0u);
}

constexpr std::size_t kHalftoneRows = 100;

/// The middles of what was burnt without a dark tick between.
std::vector<Vec2> DotsBurntIn(const fs::path& file) {
  std::vector<Vec2> dots;
  Vec2 begin_mm = Vec2::Zero();
  std::uint64_t before = 0;
  const auto record = formats::ReadMarkRecord(file);
  EXPECT_TRUE(record) << file;
  for (const auto& tick : record.value_or(formats::MarkRecord()).ticks) {
    if (dots.empty() || tick.tick != before + 1) {
      dots.emplace_back();
      begin_mm = tick.place_mm - tick.way_mm;
    }
    before = tick.tick;
    dots.back() = (begin_mm + tick.place_mm) / 2;
  }
  return dots;
}

// A row of the halftone takes 50 ms, so that the lost host ends one in its middle.
TEST(MarkShopTest, NoDotOfARowThatWasBrokenIsMadeTwice) {
  const fs::path folder = test::FreshFolder();
  render::Canvas canvas(kHalftoneRows, kHalftoneRows);
  for (int i = 0; i < canvas.width() * canvas.height(); ++i)
    canvas.at(i % canvas.width(), i / canvas.width()) = render::Srgb(0x808080);
  ASSERT_TRUE(render::WritePng(folder / "grey.png", canvas));
  MarkShop shop({.job = "name: \"grey\" marks { items { image { file: \"grey.png\" make: "
                        "MARK_IMAGE_MAKE_DOTS } } pen { speed_mm_s: 200 } }",
                 .mark_count = kHalftoneRows},
                folder);
  ASSERT_TRUE(shop.Open()) << shop.UpOutput();
  ASSERT_TRUE(shop.Submit());
  ASSERT_TRUE(Eventually([&] { return shop.BurntTicks() > 10'000; }, 60s));
  ASSERT_EQ(shop.Kill("intaglio-marker"), 1);
  ASSERT_TRUE(shop.AwaitDone(kBound)) << shop.shown() << shop.UpOutput();
  const MarkJudgement judgement = shop.Judge();
  EXPECT_EQ(judgement.doubled + judgement.unknown + judgement.not_made, 0u);
  EXPECT_EQ(judgement.made + judgement.uncertain, kHalftoneRows);
  const std::vector<Vec2> dots = DotsBurntIn(shop.folder() / "shop/marks.rec");
  // Most places of each row have a dot.
  EXPECT_GT(dots.size(), kHalftoneRows * 7 / 10 * judgement.made);
  // Places are 0.1 mm apart, so dots that are nearer were made of one place.
  std::set<std::pair<long, long>> places;
  for (const Vec2& dot : dots) {
    const Vec2 at = (dot - dots.front()) / 0.1;
    EXPECT_TRUE(places.emplace(std::lround(at.x()), std::lround(at.y())).second);
  }
  std::cout << fmt::format("{} dots, {} rows uncertain\n", dots.size(),
                           judgement.uncertain);
}

/// A metre of web: two holes and a square every 10 mm.
class WebShop : public ::testing::Test {
 protected:
  static constexpr std::size_t kRepeats = 100, kWebMarks = 3 * kRepeats;

  WebShop() : folder_(test::FreshFolder()) {
    std::ofstream(folder_ / "label.svg")
        << R"(<svg xmlns="http://www.w3.org/2000/svg" width="8mm" height="30mm" )"
        << R"(viewBox="0 0 8 30"><circle cx="1" cy="2" r="0.5"/>)"
        << R"(<circle cx="6" cy="28" r="0.5"/><rect x="3" y="9" width="2" height="2"/>)"
        << R"(<text x="1" y="20">price</text>)"
        << R"(</svg>)";
  }
  /// A shop of a web that runs at `truth_mm_s`, and is declared to run at `asked_mm_s`.
  MarkShop ShopOf(double asked_mm_s, double truth_mm_s) const {
    const fs::path truth = folder_ / "truth.textproto";
    std::ofstream(truth) << fmt::format("head {{ web_mm_s: {} }}", truth_mm_s);
    return MarkShop({.job = JobAt(asked_mm_s),
                     .profile = "galvo-web",
                     .up = {"--lockstep", "--truth", truth.string()},
                     .mark_count = kWebMarks},
                    folder_);
  }
  /// As `intaglio marks preview` says it.
  double LargestSpeed() const {
    std::ofstream(folder_ / "preview.textproto") << JobAt(0);
    Running preview(Program("intaglio"),
                    {"marks", "preview", (folder_ / "preview.textproto").string(),
                     "--machine", "galvo-web"},
                    folder_ / "preview.txt");
    const std::string text = preview.WaitForEnd(60s).output, before = "at most ";
    const std::size_t at = text.find(before);
    EXPECT_NE(at, std::string::npos) << text;
    return at == std::string::npos ? 1 : std::stod(text.substr(at + before.size()));
  }

  fs::path folder_;

 private:
  static std::string JobAt(double speed_mm_s) {
    return fmt::format(
        "name: \"web\" marks {{ items {{ drawing {{ file: \"label.svg\" }} }} "
        "pen {{ speed_mm_s: 1500 }} repeats {{ count: {} pitch_mm: 10 }} "
        "web {{ speed_mm_s: {:.3f} }} }}",
        kRepeats, speed_mm_s);
  }
};

TEST_F(WebShop, At98PercentOfTheLargestSpeedAMetreIsMadeWithoutAMiss) {
  const double speed_mm_s = 0.98 * LargestSpeed();
  MarkShop shop = ShopOf(speed_mm_s, speed_mm_s);
  ASSERT_TRUE(shop.Open()) << shop.UpOutput();
  ASSERT_TRUE(shop.Submit());
  ASSERT_TRUE(shop.AwaitDone(kBound)) << shop.shown() << shop.UpOutput();
  const MarkJudgement judgement = shop.Judge();
  EXPECT_EQ(judgement.burnt, kWebMarks);
  EXPECT_EQ(judgement.made, kWebMarks) << shop.shown();
  EXPECT_EQ(judgement.doubled + judgement.unknown + judgement.not_made, 0u);
}

TEST_F(WebShop, At102PercentTheJobFailsBeforeAnythingIsBurnt) {
  const double speed_mm_s = 1.02 * LargestSpeed();
  MarkShop shop = ShopOf(speed_mm_s, speed_mm_s);
  ASSERT_TRUE(shop.Open()) << shop.UpOutput();
  ASSERT_TRUE(shop.Submit());
  ASSERT_TRUE(Eventually([&] { return shop.Show(), shop.IsIn("failed"); }, 60s))
      << shop.shown();
  EXPECT_THAT(shop.shown(), HasSubstr("would be missed, the first: item 1 of repeat "));
  EXPECT_THAT(shop.shown(), HasSubstr("the largest speed is "));
  EXPECT_EQ(shop.BurntTicks(), 0u);
}

TEST_F(WebShop, WithoutASpeedTheLargestIsShownAndWhatIsNotMarked) {
  const double largest_mm_s = LargestSpeed();
  MarkShop shop = ShopOf(0, 0.5 * largest_mm_s);
  ASSERT_TRUE(shop.Open()) << shop.UpOutput();
  ASSERT_TRUE(shop.Submit());
  ASSERT_TRUE(shop.AwaitDone(kBound)) << shop.shown() << shop.UpOutput();
  EXPECT_THAT(shop.shown(), HasSubstr("note       marks.web.speed_mm_s: all marks are "
                                      "made up to "));
  EXPECT_THAT(shop.shown(), HasSubstr("warning    label.svg"));
  EXPECT_EQ(shop.Judge().made, kWebMarks);
}

/// Where the repeats of a job lie on a printed web: by the plan of the job, and the
/// record of the material with its print marks. Marks that are not whole are left out.
struct RepeatsOnPrint {
  std::map<long, std::set<double>> prints;  ///< by repeat, those its marks are nearest to
  double worst_um = 0;

  /// No two repeats lie at one print mark, and no repeat at two.
  bool has_own_prints() const {
    std::set<double> all;
    return std::ranges::all_of(prints, [&](const auto& of) {
      return of.second.size() == 1 && all.insert(*of.second.begin()).second;
    });
  }
};

RepeatsOnPrint RepeatsIn(const fs::path& shop, double pitch_mm, double offset_mm) {
  RepeatsOnPrint found;
  const auto record = formats::ReadMarkRecord(shop / "marks.rec");
  EXPECT_TRUE(record);
  for (const auto& entry : fs::directory_iterator(shop / "jobs")) {
    if (!entry.path().filename().string().starts_with("1-")) continue;
    const auto plan = mark::ReadMarkFile(entry.path() / "marks.bin");
    EXPECT_TRUE(plan);
    if (!plan || !record) return found;
    std::map<std::uint32_t, std::pair<Vec2, double>> burnt;  // sum of ways, length
    for (const auto& tick : record->ticks) {
      auto& [sum, length] = burnt.try_emplace(tick.mark, Vec2(0, 0), 0).first->second;
      sum += tick.way_mm.norm() * (tick.place_mm - tick.way_mm / 2);
      length += tick.way_mm.norm();
    }
    for (const auto& [number, way] : burnt) {
      const mark::Mark& mark = plan->marks.at(number);
      if (std::abs(way.second - mark::LengthOf(mark)) > 0.05) continue;
      auto planned = mark::PlacesOf(mark, 1e-4);
      planned.push_back(planned.front());
      const Vec2 origin = way.first / way.second - mark::MiddleOf(planned);
      const auto off = [&](const formats::PrintMark& print) {
        return (origin - Vec2(print.place_mm + offset_mm, 0)).norm();
      };
      const auto nearest = std::ranges::min_element(record->prints, {}, off);
      found.prints[std::lround(mark.web_mm / pitch_mm)].insert(nearest->place_mm);
      found.worst_um = std::max(found.worst_um, 1e3 * off(*nearest));
    }
  }
  return found;
}

// The web does not wait for its marker: what it brings meanwhile stays as it is.
TEST_F(WebShop, BehindAPauseAPrintedWebGoesOnAtItsNextPrintMarks) {
  constexpr std::size_t kPrinted = 30, kPrintedMarks = 3 * kPrinted;
  const fs::path truth = folder_ / "truth.textproto";
  std::ofstream(truth) << "head { web_mm_s: 60 print_pitch_mm: 20 print_ripple_mm: 300 "
                       << "print_stretch_ratio: 0.01 print_ripple_ratio: 0.1 }";
  MarkShop shop(
      {.job = "name: \"print\" marks { items { drawing { file: \"label.svg\" } "
              "} pen { speed_mm_s: 1500 } repeats { count: 30 pitch_mm: 20 } web "
              "{ speed_mm_s: 60 eye { offset_mm: -5 tolerance_mm: 3 } } }",
       .profile = "galvo-web",
       .up = {"--truth", truth.string()},
       .mark_count = kPrintedMarks},
      folder_);
  ASSERT_TRUE(shop.Open()) << shop.UpOutput();
  ASSERT_TRUE(shop.Submit());
  ASSERT_TRUE(Eventually([&] { return shop.BurntTicks() > 3000; }, 60s)) << shop.Show();
  shop.Type({"pause", "1"});
  ASSERT_TRUE(Eventually([&] { return shop.Show(), shop.IsIn("paused"); }, 60s))
      << shop.shown();
  ASSERT_TRUE(shop.AwaitDone(kBound)) << shop.shown() << shop.UpOutput();
  const MarkJudgement judgement = shop.Judge();
  EXPECT_EQ(judgement.doubled + judgement.unknown + judgement.not_made, 0u);
  // A run that ends within a repeat leaves out two marks of it at most.
  EXPECT_GE(judgement.made + judgement.uncertain + 20, kPrintedMarks) << shop.shown();
  const RepeatsOnPrint found = RepeatsIn(folder_ / "shop", 20, -5);
  EXPECT_GE(found.prints.size(), kPrinted - 10);
  EXPECT_TRUE(found.has_own_prints());
  EXPECT_LE(found.worst_um, 20);
  RecordProperty("worst_um", std::to_string(found.worst_um));
}

// INTAGLIO_MARK_KILLS: kills of each program, one unless it is set; over as many jobs as
// they take.
class KilledMarkShop : public ::testing::TestWithParam<const char*> {
 protected:
  struct Campaign {
    int jobs = 0, kills = 0;
    int while_open = 0;  ///< some marks were burnt, and not all
    MarkJudgement sum;
  };

  /// Kills the program at random moments of one job, `left` times at most.
  void KillDuring(MarkShop& shop, int left) {
    const bool early = std::string(GetParam()) == "intaglio-discretizer" ||
                       std::string(GetParam()) == "intaglio-sorter";
    ASSERT_TRUE(shop.Open()) << shop.UpOutput();
    ASSERT_TRUE(shop.Submit());
    for (bool first = true; left > 0; first = false) {
      // A stage of the beginning is killed at its work, and then while it has none.
      std::this_thread::sleep_for(std::chrono::milliseconds(
          std::uniform_int_distribution(0, first && early ? 100 : 2500)(random_)));
      const std::size_t burnt = shop.BurntTicks();
      const int hit = shop.Kill(GetParam());
      left -= hit;
      campaign_.kills += hit;
      if (hit > 0 && burnt > 0 && burnt < kTicksOfJob) ++campaign_.while_open;
      // Until it goes on, or is done.
      ASSERT_TRUE(Eventually([&] { return shop.IsOpenOrOpens() && Goes(shop); }, kBound))
          << shop.shown() << shop.UpOutput();
      if (shop.IsIn("done")) return;
    }
  }
  bool Goes(MarkShop& shop) {
    shop.Show();
    // A marker or a job service that was lost before a mark was begun asks for a new arm.
    if (shop.IsIn("paused") || shop.IsIn("waiting")) shop.Type({"resume", "1"});
    return shop.IsIn("done") || shop.IsIn("engraving");
  }
  void Add(const MarkJudgement& judgement) {
    ++campaign_.jobs;
    campaign_.sum.burnt += judgement.burnt;
    campaign_.sum.made += judgement.made;
    campaign_.sum.uncertain += judgement.uncertain;
    EXPECT_EQ(judgement.doubled, 0u);
    EXPECT_EQ(judgement.unknown, 0u);
    EXPECT_EQ(judgement.not_made, 0u);
    EXPECT_EQ(judgement.made + judgement.uncertain, kMarks);
  }

  static constexpr std::size_t kTicksOfJob = 310'000;
  std::mt19937 random_{7};
  Campaign campaign_;
};

TEST_P(KilledMarkShop, NoMarkIsMadeTwiceAndNoneIsUnknown) {
  const char* const asked = std::getenv("INTAGLIO_MARK_KILLS");
  const int kills = asked != nullptr ? std::atoi(asked) : 1;
  while (campaign_.kills < kills && !HasFailure()) {
    MarkShop shop(CirclesAtRest(),
                  FolderWithCircles("job" + std::to_string(campaign_.jobs)));
    KillDuring(shop, kills - campaign_.kills);
    if (HasFatalFailure()) return;
    ASSERT_TRUE(shop.AwaitDone(kBound)) << shop.shown() << shop.UpOutput();
    const MarkJudgement judgement = shop.Judge();
    Add(judgement);
    std::cout << fmt::format("job {}: {} kills so far, {} marks uncertain\n",
                             campaign_.jobs, campaign_.kills, judgement.uncertain);
  }
  const std::string figures = fmt::format(
      "{}: {} kills in {} jobs, {} while marks were open; {} marks made, {} uncertain",
      GetParam(), campaign_.kills, campaign_.jobs, campaign_.while_open,
      campaign_.sum.made, campaign_.sum.uncertain);
  std::cout << figures << std::endl;
  RecordProperty("figures", figures);
}

INSTANTIATE_TEST_SUITE_P(EveryProgram, KilledMarkShop,
                         ::testing::Values("intaglio-job-service", "intaglio-discretizer",
                                           "intaglio-sorter", "intaglio-marker",
                                           "virtual-engraver", "intaglio-up"),
                         [](const auto& program) {
                           std::string name = program.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace intaglio
