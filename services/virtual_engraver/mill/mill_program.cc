#include "services/virtual_engraver/mill/mill_program.h"

#include <array>
#include <chrono>
#include <cmath>
#include <fstream>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <thread>
#include <vector>

#include "services/platform/link/real_time.h"
#include "services/virtual_engraver/lines/machine_line.h"
#include "services/virtual_engraver/lines/panel.h"

namespace intaglio::virtual_engraver {
namespace {

constexpr auto kMillTurn = std::chrono::milliseconds(1);
constexpr double kMillTravel_mm = 2000;  // a profile of a mill has no travel
constexpr double kSpindle_rpm = 24000;   // $30 of a mill

Vec3 PlaceOfSteps(const grbl::Steps& steps, double steps_per_mm) {
  return Vec3(double(steps[0]), double(steps[1]), double(steps[2])) / steps_per_mm;
}

/// What the machine writes down of itself.
class MillRecord {
 public:
  explicit MillRecord(const MillProgramOptions& options)
      : steps_per_mm_(options.controller.motion.steps_per_mm) {
    Open(options.flashes, flashes_);
    Open(options.way, way_);
    Open(options.cut_record, cuts_);
    if (!cuts_.is_open()) return;
    WriteBytes(formats::EncodeToolWayHeader(options.sheet));
    cuts_.flush();
  }

  void Add(const grbl::VirtualGrblMotion& motion) {
    AddFlashes(motion);
    AddWay(motion.way());
  }

 private:
  static void Open(const std::filesystem::path& file, std::ofstream& out) {
    if (file.empty()) return;
    out.open(file, std::ios::binary);
    if (!out) throw std::runtime_error("cannot write " + file.string());
  }
  void WriteBytes(const std::vector<std::byte>& bytes) {
    cuts_.write(reinterpret_cast<const char*>(bytes.data()),
                static_cast<std::streamsize>(bytes.size()));
  }
  void AddFlashes(const grbl::VirtualGrblMotion& motion) {
    const auto& flashes = motion.flashes();
    const std::size_t ended = flashes.size() - (motion.lit() ? 1 : 0);
    if (!flashes_.is_open() || flash_count_ == ended) return;
    for (; flash_count_ < ended; ++flash_count_) {
      const grbl::Flash& flash = flashes[flash_count_];
      flashes_ << "flash " << PlaceOfSteps(flash.on_at, steps_per_mm_).transpose() << ' '
               << flash.off_us - flash.on_us << ' ' << flash.at_rest_us << ' '
               << flash.line << '\n';
    }
    flashes_ << "rest " << motion.lit_at_rest_us() << std::endl;
  }
  void AddWay(const std::vector<grbl::WayEnd>& way) {
    if (end_count_ == way.size()) return;
    std::vector<std::byte> bytes;
    for (; end_count_ < way.size(); ++end_count_) {
      const grbl::WayEnd& end = way[end_count_];
      const Vec3 at_mm = PlaceOfSteps(end.at, steps_per_mm_);
      const auto at_us = static_cast<std::uint64_t>(std::llround(end.at_us));
      formats::AppendToolWayStep({at_us, at_mm, end.power, end.on}, bytes);
      if (way_.is_open())
        way_ << at_us << ' ' << at_mm.transpose() << ' ' << end.on << ' ' << end.power
             << '\n';
    }
    way_.flush();
    if (!cuts_.is_open()) return;
    WriteBytes(bytes);
    cuts_.flush();
  }

  double steps_per_mm_;
  std::ofstream flashes_, way_, cuts_;
  std::size_t flash_count_ = 0, end_count_ = 0;
};

class MillMachine {
 public:
  explicit MillMachine(const MillProgramOptions& options)
      : options_(options), controller_(options.controller), record_(options) {
    auto line = OpenMachineLine(options.line, "mill's line");
    if (!line) throw std::runtime_error(line.error().message);
    line_ = std::move(*line);
    bytes_ = line_->MachineEnd();
    if (options.panel.empty()) return;
    auto panel = Panel::Open(options.panel);
    if (!panel) throw std::runtime_error(panel.error().message);
    panel_.emplace(std::move(*panel));
  }

  std::string device() const { return line_->device(); }

  /// What `seconds` of real time bring.
  void Turn(double seconds) {
    if (line_->HostHasGone()) {
      bytes_ = line_->MachineEnd();
      connected_ = false;
    }
    std::array<std::byte, 256> buffer;
    const auto count = bytes_->Read(buffer);
    if (count && *count > 0 && !unplugged_) {
      connected_ = true;
      controller_.Write({reinterpret_cast<const char*>(buffer.data()), *count});
    }
    if (panel_)
      panel_->Poll([this](const std::string& command) { return DoAtMill(command); });
    controller_.Advance(1e6 * options_.speed * seconds);
    const std::string sent = controller_.Read();
    // Nobody keeps what a serial line carries while no host listens.
    if (!sent.empty() && connected_ && !unplugged_)
      (void)bytes_->Write(std::as_bytes(std::span(sent)));
    record_.Add(controller_.motion());
  }

 private:
  std::string DoAtMill(const std::string& command) {
    const std::map<std::string, std::function<void()>> acts = {
        {"door open", [this] { controller_.SetDoor(true); }},
        {"door close", [this] { controller_.SetDoor(false); }},
        {"hold", [this] { controller_.PressHold(); }},
        {"reset", [this] { controller_.PressReset(); }},
        {"estop press", [this] { controller_.SetEmergencyStop(true); }},
        {"estop release", [this] { controller_.SetEmergencyStop(false); }},
        {"limit", [this] { controller_.HitLimit(); }},
        {"alarm", [this] { controller_.FailDrive(); }},
        {"error", [this] { controller_.RefuseNextLine(); }},
        {"power off", [this] { controller_.SwitchOff(); }},
        {"power on", [this] { controller_.PowerCycle(); }},
        {"unplug", [this] { unplugged_ = true; }},
        {"plug", [this] { unplugged_ = false; }},
    };
    const auto act = acts.find(command);
    if (act == acts.end()) return "error: the panel has no '" + command + "'";
    act->second();
    return "ok";
  }

  const MillProgramOptions& options_;
  grbl::VirtualGrbl controller_;
  MillRecord record_;
  std::unique_ptr<MachineLine> line_;
  std::unique_ptr<link::ByteStream> bytes_;
  std::optional<Panel> panel_;
  bool unplugged_ = false, connected_ = false;
};

}  // namespace

MillProgramOptions MillOptionsOf(const MachineTruth& truth) {
  const MillTruth& mill = truth.mill();
  MillProgramOptions options;
  options.sheet = {mill.has_tool_diameter_mm() ? mill.tool_diameter_mm() : 0.2,
                   mill.has_sheet_thickness_mm() ? mill.sheet_thickness_mm() : 1.6,
                   mill.sheet_height_mm(), mill.laser()};
  grbl::VirtualGrblOptions& grbl = options.controller = grbl::GrblHal();
  grbl.serial_number = mill.has_serial_number() ? mill.serial_number() : "virtual-mill-1";
  grbl.travel_min_mm = Vec3::Constant(-kMillTravel_mm);
  grbl.travel_max_mm = Vec3::Constant(kMillTravel_mm);
  if (mill.has_acceleration_mm_s2())
    grbl.motion.acceleration_mm_s2 = mill.acceleration_mm_s2();
  if (mill.has_max_speed_mm_s()) grbl.motion.max_speed_mm_s = mill.max_speed_mm_s();
  if (mill.laser()) return options;
  grbl.laser_mode = false;
  grbl.max_power = kSpindle_rpm;
  return options;
}

int ServeMill(const MillProgramOptions& options, volatile sig_atomic_t& stop_asked) {
  using Clock = std::chrono::steady_clock;
  MillMachine machine(options);
  // A machine of steel does not wait for a busy host.
  (void)link::AskForRealTime();
  std::cout << "ready " << machine.device() << std::endl;
  auto last = Clock::now();
  while (stop_asked == 0) {
    const auto now = Clock::now();
    machine.Turn(std::chrono::duration<double>(now - last).count());
    last = now;
    std::this_thread::sleep_for(kMillTurn);
  }
  return 0;
}

}  // namespace intaglio::virtual_engraver
