#include "services/mesh_reader/program_limits.h"

#include <algorithm>
#include <chrono>
#include <filesystem>

#include "services/mesh_reader/reading_process.h"

namespace intaglio::mesh_reader {

ReadLimits LimitsOfProgram(double factor) {
  ReadLimits limits = ReadLimitsTimes(factor);
  ReadingProcess process;
  process.program = std::filesystem::read_symlink("/proc/self/exe").parent_path() /
                    "intaglio-mesh-reader";
  process.time =
      std::chrono::ceil<std::chrono::seconds>(process.time * std::max(1.0, factor));
  limits.read_mesh = ReadBy(process);
  return limits;
}

}  // namespace intaglio::mesh_reader
