// Jobs of contours through LinuxCNC itself, by the product's processes: HAL's sampler
// has the place of the axes in each period in which the beam was on.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <thread>

#include "engrave/formats/journal_file.h"
#include "engrave/mark/mark_file.h"
#include "services/drivers/interface/mark_edges.h"
#include "services/drivers/linuxcnc/marks/contour_plan.h"
#include "services/job/files/job_file.h"
#include "services/job/plan/course_motion.h"
#include "tests/integration/run_program.h"
#include "tests/services/drivers/linuxcnc/hal_machine.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

using namespace std::chrono_literals;
using testing::Eventually;
using testing::Program;
using testing::Running;

constexpr double kPeriod_s = 1e-3;
/// The tolerance of the profile, and the decimals of the sampler.
constexpr double kTolerance_mm = 0.02 + 1e-4;

class LinuxcncContourJob : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const auto why = linuxcnc::EnterNamespace(); !why.empty()) GTEST_SKIP() << why;
    folder_ = test::FreshFolder();
    tag_ = fmt::format("linuxcnc-contours-{}", getpid());
    std::filesystem::create_directories(folder_ / "hal");
    machine_ =
        std::make_unique<linuxcnc::HalMachine>(folder_ / "hal", "", AxesFile(), true);
    // Behind the gate: the place, and the number of the mark, in each lit period.
    machine_->Command("addf sampler.1 servo");
    machine_->Command("loadusr stdbuf -oL halsampler -c 1 " +
                      (folder_ / "hal" / "beam").string());
    std::string profile =
        test::ContentOf(INTAGLIO_SOURCE_DIR "/deploy/machines/linuxcnc-cutter.textproto");
    const std::string supplied = "/run/intaglio-linuxcnc";
    profile.replace(profile.find(supplied), supplied.size(), machine_->folder().string());
    std::ofstream(folder_ / "machine.textproto") << profile;
    shop_ = std::make_unique<Running>(
        Program("intaglio"),
        With({"up", "--real-machine", "--machine", folder_ / "machine.textproto",
              "--folder", folder_ / "shop", "--materials", folder_ / "materials.db",
              "--piece", "plywood"}),
        folder_ / "shop.log");
    ASSERT_TRUE(Eventually(
        [&] { return shop_->Output().find("the shop is open") != std::string::npos; },
        40s))
        << shop_->Output();
  }
  void TearDown() override {
    if (shop_ == nullptr) return;
    shop_->Signal(SIGTERM);
    shop_->WaitForEnd(20s);
    shop_.reset();
    machine_.reset();
  }
  /// The supplied one, and an instrument of HAL: for how many seconds the beam's bit was
  /// on while a latch was open or the watchdog had tripped.
  std::filesystem::path AxesFile() const {
    const auto file = folder_ / "axes.hal";
    std::ofstream(file)
        << test::ContentOf(INTAGLIO_SOURCE_DIR "/deploy/linuxcnc/simulated.hal")
        << "loadrt lut5 names=wrong\nloadrt conv_bit_float names=wrong-bit\n"
           "loadrt integ names=wrong-time\n"
           "net laser-out => wrong.in-0\nnet laser-ok => wrong.in-1\n"
           "net motion-ok => wrong.in-2\nnet host-alive => wrong.in-3\n"
           "net lamp-warm => wrong.in-4\n"
           // In-0, and not all of the others: 0x2AAAAAAA.
           "setp wrong.function 715827882\n"
           "net wrong-on wrong.out => wrong-bit.in\n"
           "net wrong-number wrong-bit.out => wrong-time.in\n"
           "addf wrong servo\naddf wrong-bit servo\naddf wrong-time servo\n";
    return file;
  }
  std::vector<std::string> With(std::vector<std::string> words) const {
    words.insert(words.end(), {"--domain", "74", "--tag", tag_});
    return words;
  }
  std::string Type(std::vector<std::string> words) const {
    Running run(Program("intaglio"), With(std::move(words)), folder_ / "typed.txt");
    return run.WaitForEnd(60s).output;
  }
  /// A plate whose notches have sharp corners, a hole and a slot with round ends.
  void Submit(double speed_mm_s) {
    ++job_;
    before_ = Beam().size();
    std::ofstream(folder_ / "plate.svg")
        << R"(<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="40mm" )"
        << R"(viewBox="0 0 60 40"><path d="M 5 5 H 45 L 55 15 V 30 H 42 L 36 24 L 32 32 H 22 V 27 H 18 V 32 H 5 Z"/>)"
        << R"(<circle cx="15" cy="18" r="5"/>)"
        << R"(<path d="M 28 12 H 40 A 3 3 0 0 1 40 18 H 28 A 3 3 0 0 1 28 12 Z"/></svg>)";
    std::ofstream(folder_ / "plate.textproto") << fmt::format(
        "name: \"plate\" machine_file: \"machine.textproto\" course {{ files: "
        "\"plate.svg\" make: COURSE_MAKE_CUT tool_diameter_mm: 0.2 power_ratio: 1 "
        "speed_mm_s: {} }}\n",
        speed_mm_s);
    const std::string answer = Type({"submit", folder_ / "plate.textproto", "--arm"});
    ASSERT_NE(answer.find("job "), std::string::npos) << answer;
  }
  bool IsDone() { return State("done"); }
  bool State(const std::string& state) {
    shown_ = Type({"show", Job()});
    return shown_.find("state      " + state) != std::string::npos;
  }
  /// As a person does: without a consent to make anything uncertain again.
  bool GoOnUntilDone() {
    return Eventually(
        [&] {
          if (IsDone()) return true;
          if (shown_.find("state      paused") != std::string::npos)
            Type({"resume", Job()});
          if (State("waiting for arm")) Type({"arm", Job()});
          return false;
        },
        150s);
  }
  std::filesystem::path JobFolder() const {
    for (const auto& job : std::filesystem::directory_iterator(folder_ / "shop" / "jobs"))
      if (job.path().filename().string().starts_with(Job() + "-")) return job.path();
    return {};
  }
  mark::MarkSet Marks() const {
    const auto marks = mark::ReadMarkFile(JobFolder() / "marks.bin");
    EXPECT_TRUE(marks) << marks.error().message;
    return marks ? *marks : mark::MarkSet();
  }
  std::string Job() const { return std::to_string(job_); }
  std::string Beam() const {
    const auto file = folder_ / "hal" / "beam";
    return std::filesystem::exists(file) ? test::ContentOf(file) : "";
  }
  /// The places of each mark of the job in which the beam was on, in order.
  std::map<std::uint32_t, std::vector<Vec2>> Lit() const {
    std::istringstream in(Beam().substr(before_));
    std::map<std::uint32_t, std::vector<Vec2>> lit;
    std::uint32_t number = 0;
    for (Vec3 at; in >> number >> at.x() >> at.y() >> at.z();)
      lit[number - 1].push_back(at.head<2>());
    return lit;
  }
  bool IsLit() const { return Lit().size() > 1; }
  std::size_t PlannedPeriods(const mark::MarkSet& set, std::uint32_t mark) const {
    const auto machine = ReadMachineFile(folder_ / "machine.textproto");
    const mark::Mark& one = set.marks[mark];
    const auto plan =
        drivers::PlanContour(one, set.pens[one.pen], machine.value(), kPeriod_s);
    EXPECT_TRUE(plan) << plan.error().message;
    return plan ? plan->lit_end - plan->lit_begin : 0;
  }
  bool IsWhole() const {
    const auto journal = formats::ReadJournal(JobFolder() / "journal.bin");
    return journal && std::ranges::none_of(journal->records, [](const auto& one) {
             return one.kind == formats::JournalKind::kOutcome &&
                    one.outcome == formats::PointOutcome::kUncertain;
           });
  }
  /// Nothing lit beside its mark; no mark lit for longer than once takes.
  void ExpectNothingTwiceAndNothingBeside(const mark::MarkSet& set) const {
    for (const auto& [mark, places_mm] : Lit()) {
      ASSERT_LT(mark, set.marks.size());
      EXPECT_LE(places_mm.size(), PlannedPeriods(set, mark)) << "mark " << mark;
      const contour::Edges edges = drivers::EdgesOfMark(set.marks[mark]);
      double worst_mm = 0;
      for (const Vec2& at_mm : places_mm)
        worst_mm = std::max(worst_mm, Distance(edges, at_mm));
      EXPECT_LE(worst_mm, kTolerance_mm) << "mark " << mark;
    }
  }
  static double Distance(const contour::Edges& edges, const Vec2& at_mm) {
    double nearest_mm = 1e9;
    for (const contour::Edge& edge : edges)
      nearest_mm = std::min(nearest_mm, contour::DistanceTo(edge, at_mm));
    return nearest_mm;
  }

  std::filesystem::path folder_;
  std::string tag_, shown_;
  int job_ = 0;
  std::size_t before_ = 0;  ///< bytes of HAL's record before the job
  std::unique_ptr<linuxcnc::HalMachine> machine_;
  std::unique_ptr<Running> shop_;
};

TEST_F(LinuxcncContourJob, IsCutAsPlannedAndFasterThanWithStops) {
  // On a computer that was too busy a contour was ended: then the job is made again.
  constexpr int kJobs = 3;
  bool whole = false;
  for (int job = 0; job < kJobs && !whole; ++job) {
    Submit(40);
    ASSERT_TRUE(GoOnUntilDone()) << shown_ << shop_->Output();
    whole = IsWhole();
  }
  const mark::MarkSet set = Marks();
  ASSERT_EQ(set.marks.size(), 3u);
  const auto lit = Lit();
  double lit_s = 0, stopping_s = 0, worst_mm = 0, missed_mm = 0;
  for (std::uint32_t mark = 0; mark < set.marks.size(); ++mark) {
    ASSERT_TRUE(lit.contains(mark));
    const std::vector<Vec2>& places_mm = lit.at(mark);
    EXPECT_EQ(places_mm.size(), PlannedPeriods(set, mark));
    const contour::Edges edges = drivers::EdgesOfMark(set.marks[mark]);
    contour::Edges way;
    for (std::size_t k = 0; k < places_mm.size(); ++k) {
      worst_mm = std::max(worst_mm, Distance(edges, places_mm[k]));
      if (k > 0 && (places_mm[k] - places_mm[k - 1]).norm() > 1e-9)
        way.push_back(contour::MakeLine(places_mm[k - 1], places_mm[k]));
    }
    for (const contour::Edge& edge : edges) {
      for (int k = 0; k <= 50; ++k)
        missed_mm = std::max(
            missed_mm, Distance(way, contour::PointAt(edge, edge.length_mm * k / 50)));
    }
    lit_s += kPeriod_s * static_cast<double>(places_mm.size());
    const auto path = CoursePathAlong(edges, 40).value();
    const std::vector<double> stops(path.node_count() - 2, 0);
    stopping_s += course::PlanSpeeds(path, stops, 2000).duration_s;
  }
  EXPECT_LE(worst_mm, kTolerance_mm);
  EXPECT_LE(missed_mm, kTolerance_mm);
  EXPECT_LT(lit_s, 0.9 * stopping_s);
  EXPECT_EQ(machine_->ValueOf("wrong-time.out"), 0);
  std::cout << fmt::format(
      "  lit for {:.3f} s, with stops {:.3f} s; {:.1f} um from the contours, {:.1f} um "
      "missed\n",
      lit_s, stopping_s, 1e3 * worst_mm, 1e3 * missed_mm);
}

TEST_F(LinuxcncContourJob, HasAProfileThatIsGood) {
  Running check(Program("intaglio"),
                {"machine", "check", folder_ / "machine.textproto", "--json"},
                folder_ / "check.json");
  const auto ended = check.WaitForEnd(60s);
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_NE(ended.output.find("mark_line"), std::string::npos) << ended.output;
  EXPECT_EQ(ended.output.find("notCompared"), std::string::npos) << ended.output;
}

struct Blow {
  const char* name;
  const char* hits;     ///< a program; null: none
  int signal;           ///< to it; SIGSTOP: for a second
  const char* command;  ///< of halcmd, and its undoing
  const char* undo;
};

class LinuxcncContourBlow : public LinuxcncContourJob,
                            public ::testing::WithParamInterface<Blow> {};

TEST_P(LinuxcncContourBlow, EndsTheBeamAndMakesNothingTwice) {
  Submit(10);
  ASSERT_TRUE(Eventually([&] { return IsLit(); }, 60s)) << shop_->Output();
  if (GetParam().hits != nullptr) {
    const auto processes = testing::ProcessesWith({GetParam().hits, tag_});
    ASSERT_EQ(processes.size(), 1u);
    kill(processes.front(), GetParam().signal);
    std::this_thread::sleep_for(1s);
    if (GetParam().signal == SIGSTOP) kill(processes.front(), SIGCONT);
  } else {
    machine_->Command(GetParam().command);
    std::this_thread::sleep_for(1s);
    machine_->Command(GetParam().undo);
  }
  ASSERT_TRUE(GoOnUntilDone()) << shown_ << shop_->Output();
  const mark::MarkSet set = Marks();
  ASSERT_EQ(set.marks.size(), 3u);
  ExpectNothingTwiceAndNothingBeside(set);
  // But for the period in which it is switched off: the instrument runs before the gate.
  EXPECT_LE(machine_->ValueOf("wrong-time.out"), 0.003);
  std::size_t whole = 0;
  for (const auto& [mark, places_mm] : Lit())
    whole += places_mm.size() == PlannedPeriods(set, mark);
  EXPECT_GE(whole, 1u);
}

INSTANTIATE_TEST_SUITE_P(
    Of, LinuxcncContourBlow,
    ::testing::Values(
        Blow{"marker", "intaglio-marker", SIGKILL, "", ""},
        Blow{"marker_frozen", "intaglio-marker", SIGSTOP, "", ""},
        Blow{"job_service", "intaglio-job-service", SIGKILL, "", ""},
        Blow{"stop", nullptr, 0, "sets stop-released 0", "sets stop-released 1"},
        Blow{"door", nullptr, 0, "sets door-closed 0", "sets door-closed 1"},
        Blow{"drives", nullptr, 0, "sets drives-ready 0", "sets drives-ready 1"},
        Blow{"place", nullptr, 0, "sets axes-homed 0", "sets axes-homed 1"}),
    [](const auto& blow) { return std::string(blow.param.name); });

}  // namespace
}  // namespace intaglio
