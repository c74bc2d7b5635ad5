// Any bytes as a batch: refused with a sentence, or lines whose order can be checked and
// whose jobs can be made, without a crash.

#include <cstdint>
#include <string_view>

#include "engrave/core/check.h"
#include "services/job/files/batch_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio;
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  JobSpec pattern;
  pattern.set_name("{name}");
  pattern.add_models()->set_file("/models/a.stl");
  for (const auto& lines : {ParseBatchJson(text), ParseBatchCsv(text)}) {
    if (!lines) {
      Require(!lines.error().message.empty(), "an error without a sentence");
      continue;
    }
    Require(!lines->empty(), "a batch without jobs");
    for (const Error& error : CheckBatchOrder(*lines)) {
      Require(!error.message.empty(), "an error without a sentence");
    }
    std::size_t last = 0;
    for (const BatchLine& line : *lines) {
      Require(line.line_number > last, "lines out of order");
      last = line.line_number;
      const auto job = JobOf(line, pattern, "/batch");
      Require(job || !job.error().message.empty(), "an error without a sentence");
    }
  }
  return 0;
}
