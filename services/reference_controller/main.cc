#include <signal.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <iostream>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>

#include "services/platform/command_line/program.h"
#include "services/platform/link/real_time.h"
#include "services/reference_controller/board_file.h"
#include "services/reference_controller/edge_record.h"
#include "services/reference_controller/exact_time.h"
#include "services/reference_controller/gpio_pins.h"
#include "services/reference_controller/host_line.h"
#include "services/reference_controller/measure.h"
#include "services/reference_controller/measure_steps.h"
#include "services/reference_controller/simulated_panel.h"
#include "services/reference_controller/simulated_pins.h"
#include "services/reference_controller/simulated_stage.h"
#include "services/reference_controller/stage_board.h"
#include "services/reference_controller/stage_thread.h"

namespace {

using namespace intaglio;
using namespace intaglio::reference_controller;
using std::chrono::nanoseconds;

volatile sig_atomic_t stop_asked = 0;

struct Options {
  std::string board_file, line, stage_board_file, stage_line, edges, panel;
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
  app.AddOption("--stage-board", o.stage_board_file,
                "board file of the stage: its lines and axes (proto/stage_board.proto)");
  app.AddOption("--stage-line", o.stage_line, "motion line, as --line");
  app.AddOption("--baud", o.baud, "of serial ports").ShowDefault();
  app.AddOption("--simulate", o.edges,
                "no line of a chip is touched: the edges of simulated outputs are "
                "recorded in this file");
  app.AddOption("--panel", o.panel,
                "with --simulate: Unix socket for its key, door, stop button and drives");
  app.AddOption("--measure", o.measure_s,
                "in place of a line: fire simulated outputs for so many seconds, or with "
                "--stage-board step them, and print how exact the times of their edges "
                "are")
      .Positive();
  app.AddOption("--rate", o.rate_hz, "rate of --measure, Hz; one of the board's")
      .ShowDefault();
}

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

int Measure(const Options& o, const LaserBoard& board,
            const std::optional<StageBoard>& stage) {
  AskForTime();
  const auto stops = [] { return stop_asked != 0; };
  if (stage) {
    std::cout << ToText(ValueOrThrow(
        MeasureSteps(OptionsOf(*stage, 1), o.measure_s, ExactTime(), stops)));
    return 0;
  }
  std::cout << ToText(ValueOrThrow(
      MeasureJitter(OptionsOf(board, 1), o.rate_hz, o.measure_s, ExactTime(), stops)));
  return 0;
}

SimulatedPinsOptions SimulatedPinsOf(const LaserBoard& board) {
  SimulatedPinsOptions pins;
  pins.channels = board.shutters_size();
  pins.has_lamp_sync = board.has_lamp_sync();
  pins.output_count = board.outputs_size();
  pins.input_count = board.inputs_size();
  const double rate_hz = OptionsOf(board, 1).laser.rates_hz.front();
  if (!board.has_lamp_trigger())
    pins.flash_period = nanoseconds(static_cast<std::int64_t>(1e9 / rate_hz));
  return pins;
}

// Another number is another clock, for the host.
std::uint32_t PowerUp() { return std::max(1U, std::random_device{}()); }

/// The edges of both controllers' simulated outputs.
class SharedRecord {
 public:
  explicit SharedRecord(const std::string& file)
      : record_(ValueOrThrow(EdgeRecord::Create(file))) {}
  void Add(const Edge& edge) {
    const std::scoped_lock lock(mutex_);
    record_.Add(edge);
    if (edge.output == Output::kInPosition) in_position = edge.on;
  }

  std::atomic<bool> in_position{false};  ///< the wire between both

 private:
  std::mutex mutex_;
  EdgeRecord record_;
};

/// A stage with its board, line and thread.
class ServedStage {
 public:
  ServedStage(const Options& o, const StageBoard& board, const ControllerTime& time,
              SharedRecord* record)
      : options_(OptionsOf(board, PowerUp())),
        pins_(MakePins(board, time, record)),
        simulated_(dynamic_cast<SimulatedStage*>(pins_.get())),
        controller_(options_, *pins_, time),
        line_(ValueOrThrow(HostLine::Open(
            {o.stage_line, o.baud, "motion line"},
            [this](auto end) { controller_.Plug(std::move(end)); },
            [this] { return controller_.is_plugged(); }))),
        thread_(controller_, line_, time) {}

  StageController& controller() { return controller_; }
  StageThread& thread() { return thread_; }
  /// Null: the stage is a real one.
  SimulatedStage* simulated() { return simulated_; }
  std::string device() const { return line_.device(); }

 private:
  std::unique_ptr<Pins> MakePins(const StageBoard& board, const ControllerTime& time,
                                 SharedRecord* record) const {
    if (record == nullptr) return ValueOrThrow(OpenGpioPins(BoardLines(board)));
    SimulatedStageOptions simulated{options_.steps, *options_.stage.homing};
    simulated.at_mm = virtual_engraver::StartMm(options_.stage);
    return std::make_unique<SimulatedStage>(
        simulated, time.clock, [record](const Edge& edge) { record->Add(edge); });
  }

  StageControllerOptions options_;
  std::unique_ptr<Pins> pins_;
  SimulatedStage* simulated_;  // pins_
  StageController controller_;
  HostLine line_;
  StageThread thread_;
};

std::unique_ptr<Pins> MakeLaserPins(const LaserBoard& board, bool has_stage,
                                    const ControllerTime& time, SharedRecord* record) {
  if (record == nullptr) return ValueOrThrow(OpenGpioPins(BoardLines(board)));
  SimulatedPinsOptions simulated = SimulatedPinsOf(board);
  if (has_stage) simulated.in_position = &record->in_position;
  return std::make_unique<SimulatedPins>(
      simulated, time.clock, [record](const Edge& edge) { record->Add(edge); });
}

std::optional<SimulatedPanel> OpenPanel(const Options& o, Pins& laser,
                                        std::optional<ServedStage>& stage) {
  if (o.panel.empty()) return std::nullopt;
  return ValueOrThrow(SimulatedPanel::Open(o.panel, dynamic_cast<SimulatedPins&>(laser),
                                           stage ? stage->simulated() : nullptr));
}

int Serve(const Options& o, const LaserBoard& board,
          const std::optional<StageBoard>& stage_board) {
  const ControllerTime time = ExactTime();
  AskForTime();
  std::unique_ptr<SharedRecord> record;
  if (!o.edges.empty()) record = std::make_unique<SharedRecord>(o.edges);
  const std::unique_ptr<Pins> pins =
      MakeLaserPins(board, stage_board.has_value(), time, record.get());
  std::optional<ServedStage> stage;
  ControllerOptions options = OptionsOf(board, PowerUp());
  options.on_tick = [&stage](const TickNotice& notice) {
    if (stage) stage->controller().ReceiveTick(notice);
  };
  if (stage_board) {
    options.stage = [&stage] {
      return stage ? stage->controller().witness() : StageWitness();
    };
  }
  Controller controller(options, *pins, time);
  HostLine line = ValueOrThrow(HostLine::Open(
      {o.line, o.baud, "laser line"},
      [&controller](auto end) { controller.Plug(std::move(end)); },
      [&controller] { return controller.is_plugged(); }));
  if (stage_board) stage.emplace(o, *stage_board, time, record.get());
  std::optional<SimulatedPanel> panel = OpenPanel(o, *pins, stage);
  std::cout << "ready line=" << line.device();
  if (stage) std::cout << " stage=" << stage->device();
  std::cout << std::endl;
  while (stop_asked == 0 && !(stage && stage->thread().has_failed())) {
    line.Renew();
    if (panel) panel->Poll();
    const nanoseconds idle = ValueOrThrow(controller.Turn());
    if (idle.count() > 0) line.WaitFor(idle);
  }
  controller.MakeSafe();
  if (stage) {
    if (const std::string error = stage->thread().Stop(); !error.empty())
      throw std::runtime_error(error);
  }
  std::cout << "ends with all outputs off" << std::endl;
  return 0;
}

int Run(const Options& o) {
  const LaserBoard board = ValueOrThrow(ReadBoardFile(o.board_file));
  std::optional<StageBoard> stage;
  if (!o.stage_board_file.empty()) {
    stage = ValueOrThrow(ReadStageBoardFile(o.stage_board_file));
    if (const Status apart = CheckLinesApart(board, *stage); !apart)
      throw std::runtime_error(o.stage_board_file + ": " + apart.error().message);
  }
  return o.measure_s > 0 ? Measure(o, board, stage) : Serve(o, board, stage);
}

}  // namespace

int main(int argc, char** argv) {
  command_line::Program program("intaglio-reference-controller",
                                "a controller of a laser, and of a stage, by a Linux "
                                "board's GPIO lines");
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
  if (options.stage_line.empty() !=
      (options.stage_board_file.empty() || options.measure_s > 0)) {
    std::cerr << "intaglio-reference-controller: give --stage-board and --stage-line "
                 "together; to measure, --stage-board alone\n";
    return 2;
  }
  if (!options.panel.empty() && (options.edges.empty() || options.line.empty())) {
    std::cerr << "intaglio-reference-controller: --panel is of --simulate, with a line\n";
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
