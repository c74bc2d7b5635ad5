#include <poll.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <memory>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engrave/core/try.h"
#include "services/platform/command_line/program.h"
#include "services/platform/link/real_time.h"
#include "services/platform/link/serial_port.h"
#include "services/reference_controller/board_file.h"
#include "services/reference_controller/edge_record.h"
#include "services/reference_controller/exact_time.h"
#include "services/reference_controller/gpio_pins.h"
#include "services/reference_controller/measure.h"
#include "services/virtual_engraver/lines/machine_line.h"

namespace {

using namespace intaglio;
using namespace intaglio::reference_controller;
using std::chrono::nanoseconds;

volatile sig_atomic_t stop_asked = 0;

struct Options {
  std::string board_file, line, edges;
  std::uint32_t baud = 115200;
  double measure_s = 0, rate_hz = 100;
};

void AddOptions(command_line::Command app, Options& o) {
  app.AddOption("--board", o.board_file,
                "board file: lines of GPIO chips, and what the laser needs "
                "(proto/laser_board.proto)")
      .Require();
  app.AddOption("--line", o.line,
                "laser line: serial:DEVICE opens a serial port; else the symbolic link "
                "to make for a pseudo-terminal, or tcp:HOST:PORT to listen there");
  app.AddOption("--baud", o.baud, "of a serial port").ShowDefault();
  app.AddOption("--simulate", o.edges,
                "no line of a chip is touched: the edges of simulated outputs are "
                "recorded in this file");
  app.AddOption("--measure", o.measure_s,
                "in place of a line: fire simulated outputs for so many seconds, and "
                "print how exact the times of their edges are")
      .Positive();
  app.AddOption("--rate", o.rate_hz, "rate of --measure, Hz; one of the board's")
      .ShowDefault();
}

/// The controller's end of the line: a serial port, or a plug with the hosts that come
/// to it.
class HostLine {
 public:
  static constexpr std::string_view kSerial = "serial:";

  HostLine(const Options& options, Controller& controller)
      : controller_(controller), baud_(options.baud) {
    if (options.line.starts_with(kSerial)) {
      port_ = options.line.substr(kSerial.size());
      if (const Status opened = Open(); !opened)
        throw std::runtime_error(opened.error().message);
      return;
    }
    auto plug = virtual_engraver::OpenMachineLine(options.line, "laser line");
    if (!plug) throw std::runtime_error(plug.error().message);
    plug_ = std::move(*plug);
    controller_.Plug(plug_->MachineEnd());
  }

  std::string device() const { return plug_ ? plug_->device() : port_; }

  void Renew() {
    if (plug_ && plug_->HostHasGone()) controller_.Plug(plug_->MachineEnd());
    const auto now = std::chrono::steady_clock::now();
    if (plug_ || controller_.is_plugged() || now < next_open_) return;
    next_open_ = now + std::chrono::milliseconds(500);
    (void)Open();
  }

  void WaitFor(nanoseconds time) const {
    std::vector<pollfd> lines;
    if (plug_) {
      for (const int fd : plug_->descriptors()) lines.push_back({fd, POLLIN, 0});
    } else if (controller_.is_plugged()) {
      lines.push_back({fd_, POLLIN, 0});
    }
    const timespec timeout{0, static_cast<long>(time.count())};
    ppoll(lines.data(), lines.size(), &timeout, nullptr);
  }

 private:
  Status Open() {
    auto opened = INTAGLIO_TRY(link::OpenSerialPort(port_, baud_));
    fd_ = opened->fd();
    controller_.Plug(std::move(opened));
    return {};
  }

  Controller& controller_;
  std::uint32_t baud_;
  std::string port_;
  std::unique_ptr<virtual_engraver::MachineLine> plug_;
  int fd_ = -1;
  std::chrono::steady_clock::time_point next_open_ = {};
};

template <typename T>
T ValueOrThrow(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return *std::move(result);
}

void AskForTime() {
  const link::RealTimeGrant grant = link::AskForRealTime();
  if (grant.refused.empty()) return;
  std::cerr << "intaglio-reference-controller: ticks may be late without "
            << grant.refused << std::endl;
}

int Measure(const Options& o, const LaserBoard& board) {
  AskForTime();
  const Jitter jitter =
      ValueOrThrow(MeasureJitter(OptionsOf(board, 1), o.rate_hz, o.measure_s, ExactTime(),
                                 [] { return stop_asked != 0; }));
  std::cout << ToText(jitter);
  return 0;
}

SimulatedPinsOptions SimulatedPinsOf(const LaserBoard& board) {
  SimulatedPinsOptions pins;
  pins.channels = board.shutters_size();
  pins.has_lamp_sync = board.has_lamp_sync();
  const double rate_hz = OptionsOf(board, 1).laser.rates_hz.front();
  if (!board.has_lamp_trigger())
    pins.flash_period = nanoseconds(static_cast<std::int64_t>(1e9 / rate_hz));
  return pins;
}

int Serve(const Options& o, const LaserBoard& board) {
  const ControllerTime time = ExactTime();
  std::optional<EdgeRecord> record;
  std::unique_ptr<LaserPins> pins;
  if (o.edges.empty()) {
    pins = ValueOrThrow(OpenGpioPins(board));
  } else {
    record.emplace(ValueOrThrow(EdgeRecord::Create(o.edges)));
    pins = std::make_unique<SimulatedPins>(
        SimulatedPinsOf(board), time.clock,
        [&record](const Edge& edge) { record->Add(edge); });
  }
  // Another number is another clock of ticks, for the host.
  Controller controller(OptionsOf(board, std::max(1U, std::random_device{}())), *pins,
                        time);
  HostLine line(o, controller);
  AskForTime();
  std::cout << "ready line=" << line.device() << std::endl;
  while (stop_asked == 0) {
    line.Renew();
    const nanoseconds idle = ValueOrThrow(controller.Turn());
    if (idle.count() > 0) line.WaitFor(idle);
  }
  controller.MakeSafe();
  std::cout << "ends with all outputs off" << std::endl;
  return 0;
}

int Run(const Options& o) {
  const LaserBoard board = ValueOrThrow(ReadBoardFile(o.board_file));
  return o.measure_s > 0 ? Measure(o, board) : Serve(o, board);
}

}  // namespace

int main(int argc, char** argv) {
  command_line::Program program("intaglio-reference-controller",
                                "a laser controller of a Linux board's GPIO lines");
  program.root().SetFooter(
      "Example: intaglio-reference-controller --board els-03.board --line "
      "serial:/dev/ttyGS0\n"
      "docs/machines/els-03.md has the wiring. The hardware gate of that page is needed: "
      "no program switches off what fires after its own death.");
  Options options;
  AddOptions(program.root(), options);
  if (const auto exit_code = program.Parse(argc, argv)) return *exit_code;
  if (options.line.empty() == (options.measure_s == 0)) {
    std::cerr << "intaglio-reference-controller: give either --line or --measure\n";
    return 2;
  }
  struct sigaction action = {};
  action.sa_handler = [](int) { stop_asked = 1; };
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT})
    sigaction(number, &action, nullptr);
  signal(SIGPIPE, SIG_IGN);
  try {
    return Run(options);
  } catch (const std::exception& error) {
    std::cerr << "intaglio-reference-controller: " << error.what() << "\n";
    return 1;
  }
}
