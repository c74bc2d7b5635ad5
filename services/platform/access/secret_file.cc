#include "services/platform/access/secret_file.h"

#include <fmt/format.h>

#include "engrave/core/try.h"
#include "engrave/io/whole_file.h"

namespace intaglio::access {

Result<std::string> ReadSecretFile(const std::filesystem::path& file,
                                   std::uint64_t max_bytes) {
  using std::filesystem::perms;
  auto text = INTAGLIO_TRY(io::ReadWholeFile(file, max_bytes));
  std::error_code error;
  const perms rights = std::filesystem::status(file, error).permissions();
  if (!error && (rights & (perms::group_all | perms::others_all)) != perms::none) {
    return Fail(
        ErrorCode::kRefused,
        fmt::format("{0}: others can read or write it: chmod 600 {0}", file.string()),
        file.string());
  }
  return text;
}

}  // namespace intaglio::access
