#include "services/mesh_reader/standard_input.h"

#include <unistd.h>

#include <cstddef>
#include <vector>

#include "engrave/mesh/import/mesh_import.h"
#include "services/job/models/mesh_answer.h"
#include "services/job/reading/whole_file.h"

namespace intaglio::mesh_reader {

int ReadStandardInput(const std::string& extension, const std::string& name,
                      const mesh::ImportOptions& options) {
  // What a library prints is no part of the answer.
  const int answer_to = dup(STDOUT_FILENO);
  if (answer_to < 0 || dup2(STDERR_FILENO, STDOUT_FILENO) < 0) return 1;
  const std::vector<std::byte> bytes = reading::ReadAll(STDIN_FILENO);
  const Answer answer = mesh::ImportMeshFromMemory(bytes, extension, options, name);
  return reading::WriteAll(answer_to, EncodeAnswer(answer)) ? 0 : 1;
}

}  // namespace intaglio::mesh_reader
