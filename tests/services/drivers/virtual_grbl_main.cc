// The virtual grbl as a program, in real time:
//
//   virtual-grbl --line LINE --record FILE [--way FILE] [--hal] [--spindle]
//
// LINE: a path, for a symbolic link to a pseudo-terminal, or "tcp:127.0.0.1:0" for a TCP
// port; "ready LINE" on the output has what a host opens. Each flash of the laser is a
// line of the record when it has ended: "flash X Y Z LIT_US REST_US LINE", where it
// began, in mm; "rest US" follows with the whole time lit at rest. The way has a line for
// each end of a straight piece of the tool's way, "US X Y Z ON S": since the start, in mm
// of the machine's axes, and whether output or spindle was on along it, with which S.
// SIGUSR1 opens and closes the door, SIGUSR2 is the button of a hold. SIGTERM ends it.

#include <signal.h>

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iostream>
#include <memory>
#include <thread>

#include "services/virtual_engraver/machine_line.h"
#include "tests/services/drivers/virtual_grbl.h"

namespace {

using namespace intaglio;
volatile sig_atomic_t ends = 0, doors = 0, holds = 0;

/// Writes the flashes that have ended since the last call.
void Record(const grbl::VirtualGrblMotion& motion, std::size_t& written,
            std::ofstream& record, double steps_per_mm) {
  const auto& flashes = motion.flashes();
  const std::size_t ended = flashes.size() - (motion.lit() ? 1 : 0);
  if (written == ended) return;
  for (; written < ended; ++written) {
    const grbl::Flash& flash = flashes[written];
    record << "flash";
    for (const auto steps : flash.on_at) {
      record << ' ' << static_cast<double>(steps) / steps_per_mm;
    }
    record << ' ' << flash.off_us - flash.on_us << ' ' << flash.at_rest_us << ' '
           << flash.line << '\n';
  }
  record << "rest " << motion.lit_at_rest_us() << std::endl;
}

void RecordWay(const grbl::VirtualGrblMotion& motion, std::size_t& written,
               std::ofstream& file, double steps_per_mm) {
  const auto& way = motion.way();
  if (written == way.size()) return;
  for (; written < way.size(); ++written) {
    const grbl::WayEnd& end = way[written];
    file << std::llround(end.at_us);
    for (const auto steps : end.at)
      file << ' ' << static_cast<double>(steps) / steps_per_mm;
    file << ' ' << end.on << ' ' << end.power << '\n';
  }
  file.flush();
}

/// What a person does at the machine, by signals.
class Person {
 public:
  void ActOn(grbl::VirtualGrbl& controller) {
    if (doors_ != doors) controller.SetDoor(++doors_ % 2 == 1);
    if (holds_ != holds) {
      ++holds_;
      controller.Write("!");
    }
  }

 private:
  int doors_ = 0, holds_ = 0;
};

void Serve(virtual_engraver::MachineLine& line, const grbl::VirtualGrblOptions& options,
           const std::string& record_file, const std::string& way_file) {
  using Clock = std::chrono::steady_clock;
  grbl::VirtualGrbl controller(options);
  std::ofstream record(record_file), way;
  if (!way_file.empty()) way.open(way_file);
  Person person;
  auto bytes = line.MachineEnd();
  std::size_t written = 0, way_written = 0;
  auto last = Clock::now();
  while (ends == 0) {
    if (line.HostHasGone()) bytes = line.MachineEnd();
    std::array<std::byte, 256> buffer;
    const auto count = bytes->Read(buffer);
    if (count && *count > 0) {
      controller.Write({reinterpret_cast<const char*>(buffer.data()), *count});
    }
    person.ActOn(controller);
    const auto now = Clock::now();
    controller.Advance(std::chrono::duration<double, std::micro>(now - last).count());
    last = now;
    const std::string sent = controller.Read();
    if (!sent.empty()) (void)bytes->Write(std::as_bytes(std::span(sent)));
    Record(controller.motion(), written, record, options.motion.steps_per_mm);
    if (way.is_open())
      RecordWay(controller.motion(), way_written, way, options.motion.steps_per_mm);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::string device, record_file, way_file;
  bool hal = false, spindle = false;
  CLI::App app("A grbl for tests.");
  app.add_option("--line", device)->required();
  app.add_option("--record", record_file)->required();
  app.add_option("--way", way_file);
  app.add_flag("--hal", hal);
  app.add_flag("--spindle", spindle, "a mill: $32=0, $30=24000");
  CLI11_PARSE(app, argc, argv);
  signal(SIGTERM, [](int) { ends = 1; });
  signal(SIGUSR1, [](int) { doors = doors + 1; });
  signal(SIGUSR2, [](int) { holds = holds + 1; });
  auto line = virtual_engraver::OpenMachineLine(device, "virtual grbl");
  if (!line) {
    std::cerr << line.error().message << "\n";
    return 2;
  }
  grbl::VirtualGrblOptions options = hal ? grbl::GrblHal() : grbl::Grbl11();
  options.travel_min_mm = Vec3::Constant(-2);
  options.travel_max_mm = Vec3::Constant(172);
  if (spindle) {
    options.laser_mode = false;
    options.max_power = 24000;
  }
  std::cout << "ready " << (*line)->device() << std::endl;
  Serve(**line, options, record_file, way_file);
  return 0;
}
