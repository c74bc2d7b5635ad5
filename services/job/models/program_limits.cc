#include "services/job/models/program_limits.h"

#include <algorithm>
#include <chrono>

#include "services/job/models/reading_process.h"
#include "services/platform/command_line/other_programs.h"

namespace intaglio::mesh_reader {

ReadLimits LimitsOfProgram(double factor) {
  ReadLimits limits = ReadLimitsTimes(factor);
  ReadingProcess process;
  process.program = command_line::ProgramFolder() / "intaglio-mesh-reader";
  process.time =
      std::chrono::ceil<std::chrono::seconds>(process.time * std::max(1.0, factor));
  limits.read_mesh = ReadBy(process);
  return limits;
}

}  // namespace intaglio::mesh_reader
