#include "tests/integration/campaign/machine_under_fire.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "engrave/formats/journal_file.h"
#include "engrave/formats/mark_record.h"
#include "tests/integration/course/tool_way.h"

namespace intaglio::campaign {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::AskPanel;
using testing::Eventually;
using testing::Program;
using testing::Running;

constexpr char kDomain[] = "47";

std::vector<std::string> ArgumentsOf(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

}  // namespace

MachineUnderFire::MachineUnderFire(const MachineRow& row, fs::path folder,
                                   std::string tag)
    : row_(row),
      folder_(std::move(folder)),
      tag_(std::move(tag)),
      // Its path is short: that of a socket has 107 bytes.
      socket_(fmt::format("/tmp/fire{}", getpid())) {
  fs::create_directories(folder_ / "records");
  fs::create_directories(socket_);
  fs::permissions(socket_, fs::perms::owner_all);
  StartMachine();
  WriteProfile();
  if (!row_.drawing.empty()) std::ofstream(folder_ / "drawing.svg") << row_.drawing;
  std::ofstream(folder_ / "job.textproto")
      << row_.job << "machine_file: \"machine.textproto\"\n";
}

MachineUnderFire::~MachineUnderFire() {
  if (IsOpen()) {
    shop_->Signal(SIGTERM);
    shop_->WaitForEnd(20s);
  }
  std::error_code ignored;
  fs::remove_all(socket_, ignored);
}

void MachineUnderFire::StartMachine() {
  const fs::path records = folder_ / "records", line = folder_ / "line";
  std::vector<std::string> words;
  fs::path program;
  if (row_.controller == MachineRow::Controller::kScanHead) {
    std::ofstream(folder_ / "truth.textproto") << "head { field_mm: 100 }\n";
    program = Program("virtual-engraver");
    words = {"--truth",       folder_ / "truth.textproto",
             "--head-line",   line,
             "--mark-record", records / fmt::format("marks{}.rec", ++powered_),
             "--panel",       folder_ / "panel"};
  } else {
    program = fs::path(INTAGLIO_BIN_DIR).parent_path() / "tests/virtual-grbl";
    words = {"--line",   line,
             "--record", records / "record.txt",
             "--way",    records / "way.txt",
             "--panel",  folder_ / "panel"};
  }
  words.insert(words.end(), row_.options.begin(), row_.options.end());
  machine_ = std::make_unique<Running>(program, words, folder_ / "machine.log");
  const auto is_there = [&] { return fs::exists(line) && fs::exists(folder_ / "panel"); };
  if (!Eventually(is_there, 20s))
    throw std::runtime_error("the machine does not start: " + machine_->Output());
}

// The supplied one, with the line to the machine.
void MachineUnderFire::WriteProfile() const {
  std::ifstream in(fs::path(INTAGLIO_SOURCE_DIR "/deploy/machines") /
                   (std::string(row_.profile) + ".textproto"));
  std::ofstream out(folder_ / "machine.textproto");
  const std::string device = "/dev/ttyUSB0";
  for (std::string line; std::getline(in, line);) {
    if (const auto at = line.find(device); at != std::string::npos)
      line.replace(at, device.size(), (folder_ / "line").string());
    if (line.starts_with("laser_line")) {
      line = "laser_line { protocol: \"motion-output\" device: \"unix:" + socket_ +
             "/laser\" }";
    }
    for (const auto& [begin, field] : row_.fields)
      if (line.starts_with(begin)) line = field;
    out << line << '\n';
  }
}

std::vector<std::string> MachineUnderFire::OnTheBus(
    std::vector<std::string> words) const {
  words.insert(words.end(), {"--domain", kDomain, "--tag", tag_});
  return words;
}

bool MachineUnderFire::OpenShop() {
  shop_.reset();
  // Those of a shop that was killed end with it.
  Eventually([&] { return testing::ProcessesWith({"intaglio-", tag_}).empty(); }, 20s);
  std::vector<std::string> words = {
      "up",       "--real-machine", "--machine",   folder_ / "machine.textproto",
      "--folder", folder_ / "shop", "--materials", folder_ / "materials.db"};
  words.insert(words.end(), row_.mounted.begin(), row_.mounted.end());
  shop_ = std::make_unique<Running>(Program("intaglio"), OnTheBus(words),
                                    folder_ / fmt::format("shop{}.log", ++opened_));
  const auto is_open = [&] {
    return shop_->Output().find("the shop is open") != std::string::npos;
  };
  return Eventually([&] { return !shop_->running() || is_open(); }, 60s) && IsOpen();
}

std::string MachineUnderFire::Type(const std::string& words) const {
  Running run(Program("intaglio"), OnTheBus(ArgumentsOf(words)), folder_ / "typed.txt");
  return run.WaitForEnd(60s).output;
}

bool MachineUnderFire::Submit() {
  shown_ = Type("submit " + (folder_ / "job.textproto").string() + " --arm");
  return shown_.find("job 1") != std::string::npos;
}

const std::string& MachineUnderFire::Show() { return shown_ = Type("show 1"); }

bool MachineUnderFire::IsIn(const std::string& state) const {
  return shown_.find("state      " + state) != std::string::npos;
}

void MachineUnderFire::GoOn() {
  if (!IsOpen() && !OpenShop()) return;
  Show();
  if (shown_.find("teach zero") != std::string::npos) SetZero();
  if (IsIn("paused")) Type("resume 1");
  if (IsIn("waiting for arm")) Type("arm 1");
}

bool MachineUnderFire::AwaitDone(std::chrono::seconds bound) {
  return Eventually([&] { return GoOn(), IsIn("done"); }, bound);
}

bool MachineUnderFire::AwaitState(const std::string& state, std::chrono::seconds bound) {
  return Eventually([&] { return Show(), IsIn(state); }, bound);
}

void MachineUnderFire::Do(const FaultRow& fault, const std::string& what, bool acts) {
  if (fault.by == FaultRow::By::kPower) return SwitchPower(!acts);
  if (what.empty()) return;
  if (fault.by == FaultRow::By::kKill) return Kill(what);
  if (fault.by == FaultRow::By::kCommand) {
    Type(what);
  } else if (const std::string answer = AskPanel(folder_, what); answer != "ok\n") {
    throw std::runtime_error("the panel answers to " + what + ": " + answer);
  }
}

// A scan head is the virtual engraver's, which has no switch: it is a process.
void MachineUnderFire::SwitchPower(bool on) {
  if (row_.controller == MachineRow::Controller::kGrbl) {
    AskPanel(folder_, on ? "power on" : "power off");
  } else if (on) {
    StartMachine();
  } else {
    machine_->Signal(SIGKILL);
    machine_->WaitForEnd(5s);
    for (const char* name : {"line", "panel"}) fs::remove(folder_ / name);
  }
}

void MachineUnderFire::Kill(const std::string& service) {
  if (service == "intaglio-up") {
    shop_->Signal(SIGKILL);
    shop_->WaitForEnd(5s);
    return;
  }
  for (const pid_t process : testing::ProcessesWith({"/" + service, tag_}))
    kill(process, SIGKILL);
}

Vec3 MachineUnderFire::Place() const {
  const auto way = testing::ReadToolWay(records().machine / "way.txt");
  return way.empty() ? Vec3(Vec3::Zero()) : way.back().to_mm;
}

// On a computer that is too busy for 200 ms the machine lets go, or its line is lost; a
// person gives the command again.
std::string MachineUnderFire::DriveTo(int axis, double to_mm) const {
  // A step of the controller and its rounding.
  constexpr double kNear_mm = 0.005;
  std::string answer;
  for (int i = 0; i < 20; ++i) {
    const double way_mm = to_mm - Place()[axis];
    if (std::abs(way_mm) < kNear_mm) return "";
    answer = Type(fmt::format("teach jog {} {:.4f} --speed 20", "xyz"[axis], way_mm));
    if (!answer.empty()) std::this_thread::sleep_for(500ms);
  }
  return answer + fmt::format("{} is at {:.3f} and not at {:.3f}; ", "xyz"[axis],
                              Place()[axis], to_mm);
}

// Straight up, over the place, and down.
std::string MachineUnderFire::SetZero() const {
  constexpr double kAbove_mm = 5;
  for (const auto& [axis, to_mm] :
       {std::pair(2, kAbove_mm), std::pair(0, 0.0), std::pair(1, 0.0), std::pair(2, 0.0)})
    if (const std::string why = DriveTo(axis, to_mm); !why.empty()) return why;
  std::string answer;
  const auto is_set = [&] {
    answer = Type("teach zero");
    return answer.find("the work zero is set") != std::string::npos;
  };
  return Eventually(is_set, 10s) ? "" : "teach zero: " + answer;
}

Records MachineUnderFire::records() const {
  Records records{folder_ / "records", {}};
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder_ / "shop/jobs", none))
    if (entry.path().filename().string().starts_with("1-")) records.job = entry.path();
  return records;
}

std::uintmax_t MachineUnderFire::Activity() const {
  std::uintmax_t bytes = 0;
  for (const auto& entry : fs::directory_iterator(folder_ / "records")) {
    // Each power-up of a scan head begins another file.
    const std::uintmax_t size = fs::file_size(entry.path());
    const bool has_header = entry.path().extension() == ".rec";
    bytes += has_header ? size - std::min(size, std::uintmax_t{formats::kMarkHeaderSize})
                        : size;
  }
  return bytes;
}

std::string MachineUnderFire::Mirrors() const {
  if (row_.controller != MachineRow::Controller::kScanHead) return "";
  const std::string status = AskPanel(folder_, "status");
  const auto at = status.find("\"x\"");
  return at == std::string::npos ? status : status.substr(at);
}

Result<Account> MachineUnderFire::Judge(const std::vector<WorkPiece>& before) const {
  const Records all = records();
  const auto items = row_.items(all, before);
  if (!items) return tl::unexpected(items.error());
  const auto journal = formats::ReadJournal(all.job / "journal.bin");
  if (!journal) return tl::unexpected(journal.error());
  return AccountOf(*items, Work(), *journal, row_.near_mm);
}

}  // namespace intaglio::campaign
