#include "tests/integration/point_shop.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "engrave/formats/point_file.h"
#include "tests/test_folder.h"

namespace intaglio::testing {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr char kPointDomain[] = "49";

}  // namespace

std::string KnotOf(double height_mm, double spacing_mm) {
  return fmt::format(
      "models {{ file: \"{}/deploy/jobs/sample.obj\" placement {{ fit_height_mm: {} }} "
      "}}\ndiscretization {{ min_spacing_mm: {} }}\n",
      INTAGLIO_SOURCE_DIR, height_mm, spacing_mm);
}

PointShop::PointShop(const Options& options)
    : options_(options),
      folder_(test::FreshFolder()),
      tag_(options.controller + std::to_string(getpid())),
      socket_("/tmp/" + tag_) {
  std::string device = StartController(options);
  if (options.on_usb) {
    fs::create_directory(folder_ / "usb");
    fs::create_symlink(device, folder_ / "usb/1-2.3");
    setenv("INTAGLIO_FAKE_USB", (folder_ / "usb").c_str(), 1);
    setenv("LD_LIBRARY_PATH", INTAGLIO_FAKE_USB_FOLDER, 1);
    device = "usb:9588:9899";
  }
  fs::create_directory(socket_);
  fs::permissions(socket_, fs::perms::owner_all);
  if (options.new_options.empty()) {
    WriteProfile(options, device);
  } else {
    MakeProfile(options, device);
  }
  std::ofstream(folder_ / "job.textproto")
      << "name: \"job\"\nglass: \"N-BK7\"\nblock { size_mm { x: 50 y: 50 z: 30 } }\n"
      << options.job << "machine_file: \"shop/machine.textproto\"\n";
}

PointShop::~PointShop() {
  if (IsOpen()) {
    shop_->Signal(SIGTERM);
    shop_->WaitForEnd(20s);
  }
  unsetenv("LD_LIBRARY_PATH");
  unsetenv("INTAGLIO_FAKE_USB");
  std::error_code ignored;
  fs::remove_all(socket_, ignored);
}

std::string PointShop::InFolder(std::string text) const {
  constexpr std::string_view kFolder = "FOLDER";
  for (auto at = text.find(kFolder); at != std::string::npos; at = text.find(kFolder))
    text.replace(at, kFolder.size(), folder_.string());
  return text;
}

std::string PointShop::StartController(const Options& options) {
  for (const auto& [name, text] : options.files) std::ofstream(folder_ / name) << text;
  std::vector<std::string> words = {
      "--line", options.line.empty() ? (folder_ / "line").string() : options.line,
      "--record", record().string()};
  words.insert(words.end(), options.controller_options.begin(),
               options.controller_options.end());
  if (options.has_panel)
    words.insert(words.end(), {"--panel", (folder_ / "panel").string()});
  fs::path program =
      fs::path(INTAGLIO_BIN_DIR).parent_path() / ("tests/virtual-" + options.controller);
  if (!options.program.empty()) {
    program = Program(options.program);
    words.clear();
    for (const std::string& word : options.controller_options)
      words.push_back(InFolder(word));
  }
  controller_ = std::make_unique<Running>(program, words, folder_ / "controller.log");
  Eventually([this] { return controller_->Output().find('\n') != std::string::npos; },
             10s);
  std::istringstream ready(controller_->Output());
  std::string word, device;
  ready >> word >> device;
  EXPECT_EQ(word, "ready") << controller_->Output();
  return device;
}

// The supplied one, with these lines and a lamp that is warm at once.
void PointShop::WriteProfile(const Options& options, const std::string& device) const {
  std::ifstream in(fs::path(INTAGLIO_SOURCE_DIR "/deploy/machines") /
                   (options.profile + ".textproto"));
  std::ofstream out(profile());
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("motion_line")) {
      line = fmt::format("motion_line {{ protocol: \"{}\" device: \"{}\" {} }}",
                         options.controller, device, options.more_of_motion_line);
    } else if (line.starts_with("laser_line")) {
      line = fmt::format(
          "laser_line {{ protocol: \"motion-output\" device: \"unix:{}/laser\" "
          "}}",
          socket_);
    } else if (line.find("warm_up_s") != std::string::npos) {
      line = "  warm_up_s: 0";
    }
    for (const auto& [begin, other] : options.other_lines) {
      if (line.starts_with(begin)) line = InFolder(other);
    }
    out << line << '\n';
  }
}

// As a person makes it, with the same lines and lamp.
void PointShop::MakeProfile(const Options& options, const std::string& device) const {
  std::vector<std::string> words = {
      "machine", "new",
      INTAGLIO_SOURCE_DIR "/deploy/machines/" + options.profile + ".textproto"};
  words.insert(words.end(), options.new_options.begin(), options.new_options.end());
  words.insert(words.end(),
               {"--out", profile().string(), "--no-questions", "--set",
                "motion_line.device=" + device,
                "laser_line.device=unix:" + socket_ + "/laser", "laser.warm_up_s=0"});
  Running run(Program("intaglio"), words, folder_ / "new.txt");
  const Ended ended = run.WaitForEnd(60s);
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
}

std::string PointShop::Type(std::vector<std::string> words) const {
  words.insert(words.end(), {"--domain", kPointDomain, "--tag", tag_});
  Running run(Program("intaglio"), words, folder_ / "typed.txt");
  return run.WaitForEnd(60s).output;
}

std::unique_ptr<Running> PointShop::Start(std::vector<std::string> words) const {
  words.insert(words.end(), {"--domain", kPointDomain, "--tag", tag_});
  return std::make_unique<Running>(Program("intaglio"), words, folder_ / "started.txt");
}

bool PointShop::Open() {
  shop_.reset();
  std::vector<std::string> words = {"up",
                                    "--real-machine",
                                    "--machine",
                                    profile().string(),
                                    "--folder",
                                    (folder_ / "shop").string(),
                                    "--materials",
                                    (folder_ / "materials.db").string(),
                                    "--block",
                                    "50",
                                    "50",
                                    "30",
                                    "--block-glass",
                                    "N-BK7",
                                    "--domain",
                                    kPointDomain,
                                    "--tag",
                                    tag_};
  words.insert(words.end(), options_.up_options.begin(), options_.up_options.end());
  shop_ = std::make_unique<Running>(Program("intaglio"), words,
                                    folder_ / fmt::format("shop{}.log", ++opened_));
  const auto is_open = [this] {
    return shop_->Output().find("the shop is open") != std::string::npos;
  };
  return Eventually([&] { return !shop_->running() || is_open(); }, 60s) && IsOpen();
}

bool PointShop::Submit() const {
  return Type({"submit", (folder_ / "job.textproto").string(), "--arm"}).find("job 1") !=
         std::string::npos;
}

bool PointShop::AwaitDone(std::chrono::seconds bound, bool resuming) {
  return Eventually(
      [&] {
        if (resuming && !IsOpen() && !Open()) return false;
        shown_ = Type({"show", "1"});
        if (resuming && shown_.find("state      paused") != std::string::npos) {
          // A line that was lost with the stage at the zero of its axes, where a job
          // begins, counts as a power-up; a person finds it there.
          if (shown_.find("teach zero") != std::string::npos) Type({"teach", "zero"});
          Type({"resume", "1"});
        }
        return shown_.find("state      done") != std::string::npos;
      },
      bound);
}

void PointShop::KillController() {
  controller_->Signal(SIGKILL);
  controller_->WaitForEnd(10s);
}

int PointShop::Kill(const std::string& service) const {
  int killed = 0;
  for (const pid_t process : ProcessesWith({"/" + service, tag_}))
    killed += kill(process, SIGKILL) == 0;
  return killed;
}

PointShop::Points PointShop::PointsOfJob() const {
  fs::path job;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder_ / "shop/jobs", none)) {
    if (entry.path().filename().string().starts_with("1-")) job = entry.path();
  }
  const auto path = formats::ReadPly(job / "path.ply");
  const auto journal = formats::ReadJournal(job / "journal.bin");
  if (!path || !journal) return {};
  Points points{path->points_mm, {}};
  points.last.assign(points.at_mm.size(), formats::PointOutcome::kNone);
  for (const formats::JournalRecord& one : journal->records) {
    if (one.kind == formats::JournalKind::kOutcome)
      points.last.at(one.point) = one.outcome;
  }
  return points;
}

std::size_t PointShop::Points::UncertainCount() const {
  return static_cast<std::size_t>(
      std::ranges::count(last, formats::PointOutcome::kUncertain));
}

}  // namespace intaglio::testing
