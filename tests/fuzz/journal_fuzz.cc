// Any bytes as a journal: a whole prefix of records or an error with a message, and the
// history of its points without reading out of bounds.

#include <cstdint>
#include <cstdlib>
#include <span>

#include "engrave/formats/journal_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio::formats;
  const auto journal = ParseJournal(std::as_bytes(std::span(bytes, size)));
  if (!journal) {
    if (journal.error().message.empty()) std::abort();
    return 0;
  }
  (void)HistoryOf(*journal);
  return 0;
}
