#include <exception>
#include <iostream>

#include "services/cli/intaglio_program.h"
#include "services/client/exit_codes.h"
#include "services/platform/bus/bus_option_error.h"

int main(int argc, char** argv) {
  const auto program = intaglio::cli::IntaglioProgram();
  if (const auto exit_code = program->Parse(argc, argv)) return *exit_code;
  try {
    return program->Run();
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
