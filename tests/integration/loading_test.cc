// Several blocks on the table of one machine, engraved one job after the other in one
// shop. Whose block a crack is in is read from the glass of the virtual engraver, which
// moves and turns its blocks by its own forward kinematics, and compared with the path
// here, without the product's proof.

#include <gmock/gmock.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <fstream>
#include <map>
#include <memory>

#include "engrave/formats/journal_file.h"
#include "engrave/formats/point_file.h"
#include "tests/integration/run_job.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::Ended;
using testing::Eventually;
using ::testing::HasSubstr;
using testing::Program;
using testing::Running;
using testing::TextIn;

constexpr auto kBound = 150s;
constexpr std::uint32_t kStations = 4;
// The machine's tolerance is 30 um.
constexpr double kNearMm = 0.03;

class LoadedTable : public ::testing::TestWithParam<const char*> {
 protected:
  LoadedTable() : folder_(test::FreshFolder()) {}
  ~LoadedTable() override {
    if (!up_) return;
    up_->Signal(SIGINT);
    up_->WaitForEnd(20s);
  }
  /// A supplied machine with a table of four stations.
  std::string Profile() const {
    const std::string name = GetParam();
    std::string text =
        TextIn(INTAGLIO_SOURCE_DIR "/deploy/machines/" + name + ".textproto");
    text += name == "polar"
                ? "loading { station_count: 4 turn_rad: 1.570796 table_radius_mm: 150 }\n"
                : "loading { offsets_mm { x: 60 } offsets_mm { y: 55 } "
                  "offsets_mm { x: 61 y: 56 } }\n";
    const fs::path file = folder_ / "machine.textproto";
    std::ofstream(file) << text;
    return file.string();
  }
  std::vector<std::string> With(std::vector<std::string> words) const {
    words.insert(words.end(),
                 {"--domain", "49", "--tag", "loading" + std::to_string(getpid())});
    return words;
  }
  Ended Type(const std::vector<std::string>& words) {
    Running run(Program("intaglio"), With(words), folder_ / "typed.txt");
    return run.WaitForEnd(kBound);
  }
  void OpenShop() {
    up_ = std::make_unique<Running>(
        Program("intaglio"),
        With({"up", "--folder", (folder_ / "shop").string(), "--materials",
              (folder_ / "materials.db").string(), "--machine", Profile(), "--speed",
              "50", "--warm-up", "0", "--block", "50", "50", "30"}),
        folder_ / "up.txt");
    ASSERT_TRUE(Eventually(
        [this] { return up_->Output().find("the shop is open") != std::string::npos; },
        60s))
        << up_->Output();
  }
  std::vector<std::string> Submit(const std::string& stations,
                                  std::vector<std::string> more = {}) const {
    std::vector<std::string> words = {
        "submit",     testing::SampleJob().string(),
        "--machine",  (folder_ / "machine.textproto").string(),
        "--spacing",  "1.5",
        "--stations", stations};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  /// By station, of the jobs that have a report.
  std::map<std::uint32_t, fs::path> Proved() const {
    std::map<std::uint32_t, fs::path> folders;
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / "shop")) {
      if (entry.path().filename() != "report.json") continue;
      folders[ReportIn(entry.path().parent_path()).station()] =
          entry.path().parent_path();
    }
    return folders;
  }
  static JobReport ReportIn(const fs::path& folder) {
    JobReport report;
    EXPECT_TRUE(google::protobuf::util::JsonStringToMessage(
                    TextIn(folder / "report.json"), &report)
                    .ok());
    return report;
  }
  /// Points of the path without a crack within the tolerance.
  static std::size_t WithoutCrack(const PointList& path_mm, const PointList& cracks_mm) {
    return static_cast<std::size_t>(
        std::count_if(path_mm.begin(), path_mm.end(), [&](const Vec3& point) {
          return std::none_of(cracks_mm.begin(), cracks_mm.end(), [&](const Vec3& crack) {
            return (crack - point).norm() < kNearMm;
          });
        }));
  }
  std::map<std::uint32_t, PointList> CracksByStation() const {
    std::map<std::uint32_t, PointList> cracks_mm;
    const auto glass = formats::ReadGlassRecord(folder_ / "shop/glass.rec");
    if (!glass) return cracks_mm;
    for (const auto& crack : glass->cracks) {
      EXPECT_TRUE(crack.in_glass);
      cracks_mm[crack.station].push_back(crack.position_mm);
    }
    return cracks_mm;
  }

  fs::path folder_;
  std::unique_ptr<Running> up_;
};

TEST_P(LoadedTable, EachBlockHoldsItsOwnCloudAndNoneOfAnothers) {
  ASSERT_NO_FATAL_FAILURE(OpenShop());
  const Ended ended = Type(Submit("1,2,3,4", {"--arm", "--watch"}));
  ASSERT_TRUE(ended.in_time);
  ASSERT_EQ(ended.exit_code, 0) << ended.output << up_->Output();
  ASSERT_TRUE(Eventually([this] { return Proved().size() == kStations; }, 60s));
  const auto cracks_mm = CracksByStation();
  EXPECT_EQ(cracks_mm.size(), kStations);
  for (const auto& [station, folder] : Proved()) {
    const JobReport report = ReportIn(folder);
    EXPECT_TRUE(report.verdict().good()) << station;
    EXPECT_GT(report.points().planned(), 100u);
    EXPECT_EQ(report.points().made(), report.points().planned());
    EXPECT_EQ(report.points().stray() + report.points().doubled(), 0u);
    // Beside the plan, which a busy computer may have interrupted.
    EXPECT_GT(report.engrave().predicted_max_error_um(), 0);
    EXPECT_GE(report.engrave().wrong_mechanics_max_error_um(),
              report.engrave().predicted_rms_error_um());
    EXPECT_THAT(report.name(), HasSubstr("station " + std::to_string(station)));
    const auto journal = formats::ReadJournal(folder / "journal.bin");
    ASSERT_TRUE(journal);
    EXPECT_EQ(journal->header.station, station);
    const auto path = formats::ReadPly(folder / "path.ply");
    ASSERT_TRUE(path && cracks_mm.contains(station));
    const PointList& own_mm = cracks_mm.at(station);
    EXPECT_EQ(own_mm.size(), path->points_mm.size()) << "station " << station;
    EXPECT_EQ(WithoutCrack(path->points_mm, own_mm), 0u) << "station " << station;
  }
}

TEST_P(LoadedTable, AStationThatTheTableDoesNotHaveIsRefusedByName) {
  const std::string profile = Profile();
  const Ended ended = Type(Submit("2,5"));
  EXPECT_EQ(ended.exit_code, 2) << ended.output;
  EXPECT_THAT(ended.output, HasSubstr("station: 5 is not a station of"));
  EXPECT_THAT(ended.output, HasSubstr("give 1 to 4"));
}

INSTANTIATE_TEST_SUITE_P(Machines, LoadedTable, ::testing::Values("els-03", "polar"),
                         [](const auto& of) {
                           return std::string(of.param) == "polar" ? "ArmAndTable"
                                                                   : "LinearAxes";
                         });

}  // namespace
}  // namespace intaglio
