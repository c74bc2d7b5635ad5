#include <exception>
#include <iostream>

#include "services/cli/intaglio_program.h"
#include "services/client/exit_codes.h"
#include "services/platform/bus/bus_option_error.h"
#include "services/platform/command_line/standard_streams.h"

namespace {

int Run(const intaglio::command_line::Program& program) {
  try {
    return program.Run();
  } catch (const intaglio::bus::BusOptionError& error) {
    std::cerr << "intaglio: " << error.what() << "\n";
    return intaglio::client::kExitWrongInput;
  } catch (const intaglio::bus::NotAllowedError& error) {
    std::cerr << "intaglio: " << error.what() << "\n";
    return intaglio::client::kExitMachine;
  } catch (const std::exception& error) {
    std::cerr << "intaglio: " << error.what() << "\n";
    return intaglio::client::kExitInternal;
  }
}

}  // namespace

int main(int argc, char** argv) {
  const auto program = intaglio::cli::IntaglioProgram();
  const auto refused = program->Parse(argc, argv);
  const int exit_code = refused ? *refused : Run(*program);
  const auto written = intaglio::command_line::FlushOutput();
  if (written) return exit_code;
  std::cerr << "intaglio: " << written.error().message << "\n";
  return exit_code == 0 ? intaglio::client::kExitWrongInput : exit_code;
}
