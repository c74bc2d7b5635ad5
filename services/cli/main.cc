#include <exception>
#include <iostream>

#include "services/cli/intaglio_program.h"
#include "services/client/exit_codes.h"

int main(int argc, char** argv) {
  const auto program = intaglio::cli::IntaglioProgram();
  if (const auto exit_code = program->Parse(argc, argv)) return *exit_code;
  try {
    return program->Run();
  } catch (const std::exception& error) {
    std::cerr << "intaglio: " << error.what() << "\n";
    return intaglio::client::kExitInternal;
  }
}
