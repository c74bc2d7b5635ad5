// Any text as a message of a page, as an address file, as a path of a submission, as what
// a program printed, and as the records of a journal.

#include <cstdint>
#include <span>
#include <string>

#include "engrave/core/check.h"
#include "engrave/formats/journal_file.h"
#include "services/console/api.h"
#include "services/console/console_address.h"
#include "services/console/job_cloud.h"
#include "services/console/submit/program_run.h"
#include "services/console/submit/submit_api.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio;
  const std::string text(reinterpret_cast<const char*>(bytes), size);
  (void)console::ParseConsoleRequest(text);
  if (const auto address = console::ParseAddress(text))
    Require(console::TextOf(*address) == text, "another address");
  if (const auto path = console::ParseSubmissionPath(console::kSubmissionsPath + text)) {
    Require(path->id.find('/') == std::string::npos, "an id has no folder");
    if (console::CheckUploadName(path->file))
      Require(path->file.find('/') == std::string::npos, "a file has no folder");
  }
  std::size_t kept = 0;
  const console::ProgramEnd end = console::EndOfProgram(0, text);
  for (const std::string& object : end.json) kept += object.size();
  Require(kept + end.text.size() <= size + end.json.size() + 1, "more than was printed");
  const auto header = formats::EncodeJournalHeader({.point_count = 10, .epoch = 1});
  const auto made = console::PackMade(header, std::as_bytes(std::span(bytes, size)), 7);
  if (made) Require(made->size() <= 4 + size / 8, "more than the records have");
  return 0;
}
