// Any text as a message of a page, as an address file, and as the records of a journal.

#include <cstdint>
#include <span>
#include <string>

#include "engrave/core/check.h"
#include "engrave/formats/journal_file.h"
#include "services/console/api.h"
#include "services/console/console_address.h"
#include "services/console/job_cloud.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio;
  const std::string text(reinterpret_cast<const char*>(bytes), size);
  (void)console::ParseConsoleRequest(text);
  if (const auto address = console::ParseAddress(text))
    Require(console::TextOf(*address) == text, "another address");
  const auto header = formats::EncodeJournalHeader({.point_count = 10, .epoch = 1});
  const auto made = console::PackMade(header, std::as_bytes(std::span(bytes, size)), 7);
  if (made) Require(made->size() <= 4 + size / 8, "more than the records have");
  return 0;
}
