#include <sys/prctl.h>
#include <unistd.h>

#include <csignal>
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "engrave/image/image_file.h"
#include "services/job/reading/picture_process.h"
#include "services/job/reading/whole_file.h"
#include "services/platform/command_line/program.h"

namespace {

using namespace intaglio;

int CheckStandardInput(const image::ImageLimits& limits) {
  const std::vector<std::byte> bytes = reading::ReadAll(STDIN_FILENO);
  image::ImageOptions options;
  options.samples = image::Samples::kAsStored;
  options.limits = limits;
  const std::string_view picture(reinterpret_cast<const char*>(bytes.data()),
                                 bytes.size());
  const auto read = image::ParseImage(picture, options);
  if (read) return 0;
  const std::string& sentence = read.error().message;
  if (!reading::WriteAll(STDOUT_FILENO, std::as_bytes(std::span(sentence)))) return 1;
  return reading::ExitCodeOf(read.error().code);
}

}  // namespace

int main(int argc, char** argv) {
  // The process that asked is gone: the answer is not needed.
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  command_line::Program program(
      "intaglio-picture-reader",
      "Decodes a photo for another program of Intaglio, so that a damaged file crashes\n"
      "this one only: the file is its standard input, why it cannot be decoded its\n"
      "standard output.");
  image::ImageLimits limits;
  const command_line::Command root = program.root();
  root.AddOption("max-file-bytes", limits.max_file_bytes, "maximum size of the file")
      .ShowDefault();
  root.AddOption("max-pixels", limits.max_pixels, "maximum number of pixels")
      .ShowDefault();
  root.AddOption("max-decoder-bytes", limits.max_decoder_bytes,
                 "maximum memory of the decoder beside the picture")
      .ShowDefault();
  if (const auto exit_code = program.Parse(argc, argv)) return *exit_code;
  return CheckStandardInput(limits);
}
