#include "engrave/formats/whole_file.h"

#include <fmt/format.h>

#include <fstream>
#include <system_error>

namespace intaglio::formats {

Result<std::string> ReadWholeFile(const std::filesystem::path& file,
                                  std::uint64_t max_bytes) {
  const auto refuse = [&](ErrorCode code, std::string_view problem_and_remedy) {
    return Fail(code, fmt::format("{}: {}", file.string(), problem_and_remedy),
                file.string());
  };
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (status.type() == std::filesystem::file_type::not_found) {
    return refuse(ErrorCode::kNotFound,
                  "there is no such file; check its name and folder");
  }
  if (!error && status.type() != std::filesystem::file_type::regular) {
    return refuse(ErrorCode::kIo, "this is not a file; name a file");
  }
  std::ifstream in(file, std::ios::binary);
  const std::uint64_t size = error ? 0 : std::filesystem::file_size(file, error);
  if (error || !in) {
    return refuse(ErrorCode::kIo, "cannot be opened; check that you may read it");
  }
  if (size > max_bytes) {
    return refuse(
        ErrorCode::kTooLarge,
        fmt::format("has {} bytes, more than the {} allowed; make it smaller or "
                    "raise the limit",
                    size, max_bytes));
  }
  std::string bytes(size, '\0');
  in.read(bytes.data(), static_cast<std::streamsize>(size));
  if (!in) return refuse(ErrorCode::kIo, "cannot be read to its end; check the disk");
  return bytes;
}

}  // namespace intaglio::formats
