// The virtual isel as a program, in real time:
//
//   virtual-isel --line LINE --record FILE
//
// LINE: a path, for a symbolic link to a pseudo-terminal, or "tcp:127.0.0.1:0" for a TCP
// port; "ready LINE" on the output has what a host opens. Each flash of the output is a
// line of the record when it has ended: "flash X Y Z ON_US MOVED", in steps. It was homed
// at its panel. SIGTERM ends it.

#include <signal.h>

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <fstream>
#include <iostream>
#include <memory>
#include <span>
#include <thread>

#include "services/platform/link/real_time.h"
#include "services/virtual_engraver/lines/machine_line.h"
#include "tests/services/drivers/isel/virtual_isel.h"

namespace {

using namespace intaglio;
volatile sig_atomic_t ends = 0;

/// Writes the flashes that have ended since the last call.
void Record(const isel::VirtualIsel& controller, std::size_t& written,
            std::ofstream& record) {
  const auto& flashes = controller.flashes();
  const std::size_t ended = flashes.size() - (controller.output() ? 1 : 0);
  for (; written < ended; ++written) {
    const isel::Flash& flash = flashes[written];
    record << "flash";
    for (const std::int32_t steps : flash.place) record << ' ' << steps;
    record << ' ' << flash.off_us - flash.on_us << ' ' << flash.moved << std::endl;
  }
}

void Serve(virtual_engraver::MachineLine& line, const std::string& record_file) {
  using Clock = std::chrono::steady_clock;
  isel::VirtualIselOptions options;
  options.max_speed = 100000;
  isel::VirtualIsel controller(options);
  controller.HomeAtPanel();
  std::ofstream record(record_file);
  auto bytes = line.MachineEnd();
  std::size_t written = 0;
  auto last = Clock::now();
  while (ends == 0) {
    if (line.HostHasGone()) bytes = line.MachineEnd();
    std::array<std::byte, 256> buffer;
    const auto count = bytes->Read(buffer);
    if (count && *count > 0)
      controller.Write({reinterpret_cast<const char*>(buffer.data()), *count});
    const auto now = Clock::now();
    controller.Advance(std::chrono::duration<double, std::micro>(now - last).count());
    last = now;
    const std::string sent = controller.Read();
    if (!sent.empty()) (void)bytes->Write(std::as_bytes(std::span(sent)));
    Record(controller, written, record);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::string device, record_file;
  CLI::App app("An isel for tests.");
  app.add_option("--line", device)->required();
  app.add_option("--record", record_file)->required();
  CLI11_PARSE(app, argc, argv);
  signal(SIGTERM, [](int) { ends = 1; });
  auto line = virtual_engraver::OpenMachineLine(device, "virtual isel");
  if (!line) {
    std::cerr << line.error().message << "\n";
    return 2;
  }
  // A controller of steel does not wait for a busy host.
  (void)link::AskForRealTime();
  std::cout << "ready " << (*line)->device() << std::endl;
  Serve(**line, record_file);
  return 0;
}
