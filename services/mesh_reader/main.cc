#include <sys/prctl.h>

#include <csignal>
#include <string>

#include "services/mesh_reader/standard_input.h"
#include "services/platform/command_line/program.h"

int main(int argc, char** argv) {
  using namespace intaglio;
  // The process that asked is gone: the answer is not needed.
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  command_line::Program program(
      "intaglio-mesh-reader",
      "Reads a model for another program of Intaglio, so that a damaged file crashes "
      "this\n"
      "one only: the file is its standard input, the answer its standard output. To\n"
      "inspect a model, use intaglio discretize or intaglio measure.");
  std::string extension, name;
  mesh::ImportOptions options;
  const command_line::Command root = program.root();
  root.AddOption("extension", extension, "obj, ply, 3mf, gltf, glb, dae, 3ds or stl")
      .Require();
  root.AddOption("name", name, "name of the model in error messages").Require();
  root.AddOption("max-file-bytes", options.max_file_bytes, "maximum size of the file")
      .ShowDefault();
  root.AddOption("max-unpacked-ratio", options.max_unpacked_ratio,
                 "maximum ratio by which a 3mf may grow when it is unpacked")
      .ShowDefault();
  root.AddOption("max-triangles", options.max_triangles, "maximum number of triangles")
      .ShowDefault();
  root.AddOption("objects", options.objects,
                 "only the objects of these names, default all");
  if (const auto exit_code = program.Parse(argc, argv)) return *exit_code;
  return mesh_reader::ReadStandardInput(extension, name, options);
}
