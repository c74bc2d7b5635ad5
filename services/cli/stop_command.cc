#include "services/cli/stop_command.h"

#include <fmt/format.h>

#include <chrono>
#include <iostream>
#include <map>
#include <memory>
#include <thread>

#include "services/bus/samples.h"
#include "services/cli/bus_flags.h"
#include "services/cli/run_command.h"

namespace intaglio::cli {
namespace {

using bus::Borrow;
using bus::View;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

// A machine answers within a turn of its loop; discovery comes before that.
constexpr auto kAnswerTime = 5s;

struct StopOptions {
  bus::BusOptions bus;
  std::string cell;
  std::string reason = "pressed on the command line";
  bool reset = false;
};

/// What a cell has said of its stop.
struct StopWord {
  bool heard = false;
  bool pressed = false;
  std::uint64_t number = 0;
};

/// One machine's stop, as its synchronizer confirms it.
class CellStop {
 public:
  CellStop(bus::Bus& bus, std::string cell)
      : cell_(std::move(cell)),
        stops_(bus, bus::kEmergencyStop, cell_),
        interlocks_(bus, bus::kInterlock, cell_) {}

  const std::string& cell() const { return cell_; }
  void Press(const std::string& reason) {
    pressed_ = true;
    Write(reason, MicrosecondsNow());
  }
  /// Above every press that its synchronizer has heard of.
  void Reset() {
    pressed_ = false;
    Write("reset on the command line", std::max(MicrosecondsNow(), word_.number + 1));
  }
  /// True when the synchronizer holds what was last written.
  bool Confirmed() {
    interlocks_.Take([this](const intaglio_Interlock& sample) {
      word_ = {true, sample.bus_stop_pressed, sample.bus_stop_number};
    });
    return word_.heard && word_.pressed == pressed_ &&
           (!pressed_ || word_.number >= number_);
  }
  bool heard() {
    (void)Confirmed();
    return word_.heard;
  }

 private:
  // Of this century on every host: greater than any earlier one without asking anybody.
  static std::uint64_t MicrosecondsNow() {
    return static_cast<std::uint64_t>(
        std::chrono::duration_cast<std::chrono::microseconds>(
            std::chrono::system_clock::now().time_since_epoch())
            .count());
  }
  void Write(const std::string& reason, std::uint64_t number) {
    number_ = number;
    const std::string source = "intaglio stop";
    intaglio_EmergencyStop sample{};
    sample.cell = Borrow(cell_);
    sample.pressed = pressed_;
    sample.source = Borrow(source);
    sample.reason = Borrow(reason);
    sample.number = number_;
    if (auto written = stops_.Write(sample); !written) {
      std::cerr << "intaglio: " << written.error().message << "\n";
    }
  }

  std::string cell_;
  bus::Writer<intaglio_EmergencyStop> stops_;
  bus::Reader<intaglio_Interlock> interlocks_;
  StopWord word_;
  bool pressed_ = false;
  std::uint64_t number_ = 0;
};

template <typename Condition>
bool Until(Condition condition, std::chrono::milliseconds bound) {
  for (const auto end = Clock::now() + bound; Clock::now() < end;) {
    if (condition()) return true;
    std::this_thread::sleep_for(2ms);
  }
  return condition();
}

std::map<std::string, std::unique_ptr<CellStop>> CellsOf(bus::Bus& bus,
                                                         const StopOptions& options) {
  std::map<std::string, std::unique_ptr<CellStop>> cells;
  const auto add = [&](const std::string& cell) {
    if (!cells.contains(cell)) cells[cell] = std::make_unique<CellStop>(bus, cell);
  };
  if (!options.cell.empty()) {
    add(options.cell);
    return cells;
  }
  bus::Reader<intaglio_ServiceHealth> health(bus, bus::kServiceHealth);
  Until(
      [&] {
        health.Take([&](const intaglio_ServiceHealth& sample) {
          const bool serves = sample.role == intaglio_ROLE_SYNCHRONIZER ||
                              sample.role == intaglio_ROLE_MOTION_BRIDGE;
          if (serves && !View(sample.cell).empty()) add(std::string(View(sample.cell)));
        });
        return false;
      },
      bus.discovery_time());
  return cells;
}

int Complain(const std::string& text, int exit_code) {
  std::cerr << "intaglio: " << text << "\n";
  return exit_code;
}

int Stop(const StopOptions& options) {
  bus::Bus bus(options.bus);
  auto cells = CellsOf(bus, options);
  if (cells.empty()) {
    return Complain(
        "no machine is seen: press its own button; then check --domain, --interface and "
        "--tag",
        kExitWrongInput);
  }
  if (options.reset && cells.size() > 1) {
    return Complain("there are several machines: say which one to reset",
                    kExitWrongInput);
  }
  int exit_code = kExitGood;
  // Pressed everywhere before anything is waited for.
  for (auto& [name, cell] : cells) {
    if (!options.reset) cell->Press(options.reason);
  }
  for (auto& [name, cell] : cells) {
    if (options.reset) {
      Until([&cell = cell] { return cell->heard(); }, kAnswerTime);
      cell->Reset();
    }
    if (Until([&cell = cell] { return cell->Confirmed(); }, kAnswerTime)) {
      std::cout << name
                << (options.reset ? ": reset; an arm or a resume lets it go on\n"
                                  : ": stopped\n");
      continue;
    }
    exit_code = Complain(fmt::format("{} has not confirmed it within 5 s: {}", name,
                                     options.reset ? "is its synchronizer running?"
                                                   : "press the machine's own button"),
                         kExitMachine);
  }
  return exit_code;
}

}  // namespace

void AddStopCommand(command_line::Command app) {
  command_line::Command command = app.AddCommand(
      "stop", "emergency stop: no more pulses, the stage comes to rest, latched");
  auto options = std::make_shared<StopOptions>();
  AddBusFlags(command, options->bus);
  command.AddOption("machine", options->cell, "its name; every one that is seen");
  command.AddFlag("--reset", options->reset,
                  "release it again; nothing starts before an arm or a resume");
  command.AddOption("--reason", options->reason, "for the log").ShowDefault();
  command.SetFooter(
      "It goes by network and programs: who stands at a machine uses its button.\n"
      "Ends with 0 when the machine has confirmed it, with 4 when it has not.\n"
      "Example: intaglio stop           every machine that is seen\n"
      "  intaglio stop els-03 --reset   then: intaglio resume JOB");
  command.SetAction([options] { return Stop(*options); });
}

}  // namespace intaglio::cli
