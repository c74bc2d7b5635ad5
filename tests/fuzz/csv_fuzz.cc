#include <cstdint>
#include <string_view>

#include "engrave/core/check.h"
#include "engrave/io/csv.h"

// Every row has a field for each name, or there is an error with a sentence.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using intaglio::Require;
  const auto table = intaglio::io::ParseCsv(
      std::string_view(reinterpret_cast<const char*>(bytes), size));
  if (!table) {
    Require(!table.error().message.empty(), "an error without a sentence");
    return 0;
  }
  Require(!table->names.empty(), "a table without columns");
  std::size_t line = 0;
  for (const auto& row : table->rows) {
    Require(row.fields.size() == table->names.size(), "a row of another length");
    Require(row.line_number > line, "rows out of order");
    line = row.line_number;
  }
  return 0;
}
