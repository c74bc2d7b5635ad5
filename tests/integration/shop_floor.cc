#include "tests/integration/shop_floor.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <regex>
#include <stdexcept>

#include "engrave/formats/point_file.h"
#include "tests/integration/point_difference.h"
#include "tests/test_folder.h"

namespace intaglio::testing {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr char kSource[] = INTAGLIO_SOURCE_DIR;
constexpr char kLaser[] = "laser", kMotion[] = "motion";
constexpr double kSamePlaceMm = 0.03;

const std::vector<std::string> kSmallJob = {"--height", "4.2",    "--spacing",
                                            "0.5",      "--rate", "100"};

std::vector<std::string> Joined(std::vector<std::string> words,
                                const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

std::vector<std::string> Sample(const std::string& command,
                                const std::vector<std::string>& options) {
  return Joined({command, std::string(kSource) + "/deploy/jobs/sample.textproto"},
                options);
}

std::string SuppliedMachine() {
  return std::string(kSource) + "/deploy/machines/els-03.textproto";
}

/// Sets variables for the processes that are started while it lives.
class Environment {
 public:
  explicit Environment(const std::map<std::string, std::string>& values)
      : values_(values) {
    for (const auto& [name, value] : values_) setenv(name.c_str(), value.c_str(), 1);
  }
  ~Environment() {
    for (const auto& [name, value] : values_) unsetenv(name.c_str());
  }

 private:
  std::map<std::string, std::string> values_;
};

/// The newest of our programs.
fs::file_time_type BuiltAt() {
  fs::file_time_type newest{};
  for (const auto& entry : fs::directory_iterator(INTAGLIO_BIN_DIR)) {
    newest = std::max(newest, entry.last_write_time());
  }
  return newest;
}

/// Until it is destroyed no other process has the same.
class LockedFile {
 public:
  explicit LockedFile(const fs::path& file)
      : file_(open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)) {
    if (file_ < 0 || flock(file_, LOCK_EX) != 0)
      throw std::runtime_error("cannot lock " + file.string());
  }
  ~LockedFile() { close(file_); }
  LockedFile(const LockedFile&) = delete;
  LockedFile& operator=(const LockedFile&) = delete;

 private:
  int file_;
};

/// Made once for all tests of a build: what one needs, the others have, and wait for.
PointList MakeUndisturbed() {
  const fs::path folder = fs::path(INTAGLIO_TEST_DIR) / "undisturbed";
  fs::create_directories(folder.parent_path());
  const LockedFile lock(folder.string() + ".lock");
  const fs::path glass_file = folder / "out" / "glass.ply";
  if (!fs::exists(glass_file) || fs::last_write_time(glass_file) < BuiltAt()) {
    test::FreshFolder("undisturbed");
    std::vector<std::string> words = Sample("run", kSmallJob);
    words = Joined(words, {"--lockstep", "--out", (folder / "out").string(),
                           "--materials", (folder / "materials.db").string()});
    Running run(Program("intaglio"), words, folder / "output.txt");
    if (const Ended ended = run.WaitForEnd(60s); ended.exit_code != 0) {
      fs::remove(glass_file);
      std::cerr << ended.output;
      return {};
    }
  }
  const auto glass = formats::ReadPly(glass_file);
  return glass ? glass->points_mm : PointList{};
}

}  // namespace

bool LongTests() {
  const char* asked = std::getenv("INTAGLIO_LONG");
  return asked != nullptr && std::string(asked) == "1";
}

const PointList& UndisturbedPoints() {
  static const PointList points = MakeUndisturbed();
  return points;
}

std::string DifferenceOf(const std::vector<formats::GlassCrack>& cracks) {
  const PointList& points = UndisturbedPoints();
  PointList made_mm;
  for (const formats::GlassCrack& crack : cracks) made_mm.push_back(crack.position_mm);
  std::string text = PointDifference(points, made_mm, kSamePlaceMm);
  if (points.empty()) text += "the undisturbed run was not good\n";
  return text;
}

ShopFloor::ShopFloor(fs::path folder, Options options)
    : folder_(std::move(folder)), options_(std::move(options)) {
  if (options_.results.empty()) options_.results = folder_ / "results";
  if (options_.database.empty()) options_.database = folder_ / "jobs.db";
  if (!options_.one_line) return;
  std::string made = "/tmp/intaglio-floor-XXXXXX";
  if (mkdtemp(made.data()) == nullptr) throw std::runtime_error("no folder");
  socket_folder_ = made;
  const std::string profile = TextIn(SuppliedMachine());
  std::ofstream(MachineFile())
      << profile.substr(0, profile.find("laser_line {"))
      << "motion_line { protocol: \"virtual-cell\" device: \"" << PlugOf(kMotion)
      << "\" }\nlaser_line { protocol: \"motion-output\" device: \"unix:" << made
      << "/laser\" }\n";
}

ShopFloor::~ShopFloor() {
  running_.clear();
  if (!socket_folder_.empty()) fs::remove_all(socket_folder_);
}

std::string ShopFloor::MachineFile() const {
  return options_.one_line ? (folder_ / "machine.textproto").string() : SuppliedMachine();
}

std::vector<std::string> ShopFloor::With(std::vector<std::string> words) const {
  return Joined(std::move(words), options_.bus);
}

const TestHost* ShopFloor::HostOf(const std::string& service) const {
  return service == kSynchronizer || service == kBridge ? options_.cell : options_.office;
}

std::vector<std::string> ShopFloor::ArgumentsOf(const std::string& service) const {
  const std::string machine = MachineFile();
  std::vector<std::string> words = With({"--cell", "els-03"});
  // In real time: what shares this computer with a test is not what it tests.
  if (service == kJobService) {
    return Joined(words, {"--database", options_.database.string(), "--results",
                          options_.results.string(), "--materials-db",
                          (folder_ / "materials.db").string(), "--real-time"});
  }
  if (options_.one_line && (service == kSynchronizer || service == kBridge))
    return Joined(words, {"--machine", machine, "--real-time"});
  if (service == kSynchronizer) {
    return Joined(words,
                  {"--machine", machine, "--real-time", "--device", OpenedFor(kLaser)});
  }
  if (service == kBridge) {
    return Joined(words,
                  {"--machine", machine, "--real-time", "--device", OpenedFor(kMotion)});
  }
  return words;
}

void ShopFloor::StartMachine() {
  std::ofstream(folder_ / "truth.textproto")
      << "stage { travel_min_mm { x: -2 y: -2 z: -2 }\n"
         "        travel_max_mm { x: 172 y: 172 z: 172 }\n"
         "        first_order_lag_s: 0.0002 position_tolerance_um: 30 }\n"
         "laser { rates_hz: [1, 2, 5, 10, 25, 50, 100, 200] warm_up_s: 0.5 channels: 4 "
         "door_lock: true }\n"
         "block { size_mm { x: 50 y: 50 z: 30 } refractive_index: 1.5195\n"
         "        numerical_aperture: 0.058139534883720929 }\n";
  running_["machine"] = std::make_unique<Running>(
      Program("virtual-engraver"),
      std::vector<std::string>{"--truth", (folder_ / "truth.textproto").string(),
                               "--laser-line", PlugOf(kLaser), "--motion-line",
                               PlugOf(kMotion), "--panel", (folder_ / "panel").string(),
                               "--glass-record", (folder_ / "glass.rec").string(),
                               "--speed", fmt::format("{}", options_.machine_speed)},
      folder_ / "machine.log");
  Eventually([&] { return at("machine").Output().find("ready ") != std::string::npos; },
             5s);
}

std::string ShopFloor::PlugOf(const std::string& line) const {
  if (options_.one_line) return (folder_ / "line").string();
  return options_.lines_over_tcp ? "tcp:127.0.0.1:0" : (folder_ / line).string();
}

std::string ShopFloor::DeviceOf(const std::string& line) const {
  if (!options_.lines_over_tcp) return (folder_ / line).string();
  std::smatch device;
  const std::string output = TextIn(folder_ / "machine.log");
  return std::regex_search(output, device, std::regex(line + "=(tcp:\\S+)"))
             ? device[1]
             : std::string();
}

std::string ShopFloor::OpenedFor(const std::string& line) const {
  const auto led = led_.find(line);
  return led == led_.end() ? DeviceOf(line) : led->second;
}

void ShopFloor::Start(const std::string& service,
                      const std::map<std::string, std::string>& environment) {
  const Environment set(environment);
  std::optional<TestHost::Visit> visit;
  if (const TestHost* host = HostOf(service)) visit.emplace(*host);
  running_[service] = std::make_unique<Running>(
      Program(service), ArgumentsOf(service),
      folder_ / fmt::format("{}.{}.log", service, ++starts_[service]));
}

void ShopFloor::StartAll() {
  StartMachine();
  StartServices();
}

void ShopFloor::StartServices() {
  for (const char* service : {kJobService, kDiscretizer, kSorter, kBridge, kSynchronizer})
    Start(service);
}

Ended ShopFloor::Type(const std::vector<std::string>& words) {
  std::unique_ptr<Running> run;
  {
    std::optional<TestHost::Visit> visit;
    if (options_.office != nullptr) visit.emplace(*options_.office);
    run = std::make_unique<Running>(Program("intaglio"), With(words),
                                    folder_ / fmt::format("typed{}.txt", ++typed_));
  }
  return run->WaitForEnd(60s);
}

bool ShopFloor::Opens() {
  return Eventually([&] { return Type({"list"}).exit_code == 0; }, 40s);
}

std::optional<std::string> ShopFloor::Engrave(const std::vector<std::string>& options) {
  if (!Opens()) return std::nullopt;
  const Ended submitted =
      Type(Joined(Sample("submit", options.empty() ? kSmallJob : options), {"--arm"}));
  std::smatch number;
  if (submitted.exit_code != 0 ||
      !std::regex_search(submitted.output, number, std::regex("job ([0-9]+)"))) {
    std::cerr << submitted.output << Logs();
    return std::nullopt;
  }
  std::optional<TestHost::Visit> visit;
  if (options_.office != nullptr) visit.emplace(*options_.office);
  watch_ = std::make_unique<Running>(Program("intaglio"),
                                     With({"watch", number[1], "--events"}),
                                     folder_ / "events.txt");
  return number[1];
}

std::string ShopFloor::Events() const {
  return watch_ == nullptr ? std::string() : watch_->Output();
}

std::string ShopFloor::Newest(const std::string& field) const {
  const std::string text = Events(), key = "\"" + field + "\":\"";
  const auto at = text.rfind(key);
  if (at == std::string::npos) return {};
  const auto from = at + key.size();
  return text.substr(from, text.find('"', from) - from);
}

bool ShopFloor::Reaches(const std::string& state, std::chrono::milliseconds bound) const {
  return Eventually([&] { return Newest("state") == state; }, bound);
}

std::int64_t ShopFloor::Panel(const std::string& field) const {
  const std::string answer = AskPanel(folder_, "status");
  const std::string key = "\"" + field + "\": ";
  const auto at = answer.find(key);
  return at == std::string::npos
             ? -1
             : std::strtoll(answer.c_str() + at + key.size(), nullptr, 10);
}

bool ShopFloor::AwaitCracks(std::int64_t count, std::chrono::milliseconds bound) const {
  return Eventually([&] { return Panel("cracks") >= count; }, bound);
}

std::vector<formats::GlassCrack> ShopFloor::Cracks() const {
  const auto record = formats::ReadGlassRecord(folder_ / "glass.rec");
  return record ? record->cracks : std::vector<formats::GlassCrack>{};
}

std::string ShopFloor::Logs() const {
  std::string text;
  for (const auto& entry : fs::directory_iterator(folder_)) {
    if (entry.path().extension() != ".log") continue;
    const std::string log = TextIn(entry.path());
    text += entry.path().filename().string() + ":\n" +
            log.substr(log.size() - std::min<std::size_t>(log.size(), 2500)) + "\n";
  }
  return text + Events();
}

}  // namespace intaglio::testing
