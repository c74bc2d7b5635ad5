// write-schemas SOURCE_DIR FOLDER: writes the JSON schemas of the commands into the
// folder. A program of the build, which is not installed.

#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>

#include "services/cli/schemas/command_schemas.h"

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs("write-schemas: give the folder of the sources and that to write to\n",
               stderr);
    return 2;
  }
  try {
    const std::filesystem::path folder = argv[2];
    std::filesystem::create_directories(folder);
    for (const auto& [name, text] : intaglio::schemas::CommandSchemas(argv[1])) {
      std::ofstream file(folder / name, std::ios::binary);
      file.exceptions(std::ios::badbit | std::ios::failbit);
      file << text;
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "write-schemas: %s\n", error.what());
    return 1;
  }
  return 0;
}
