#include "services/job/reading/picture_process.h"

#include <fmt/format.h>

#include <optional>
#include <span>

#include "engrave/core/try.h"
#include "services/job/reading/file_process.h"

namespace intaglio::reading {
namespace {

/// Above those of a program that crashes or is called in a wrong way, below those of
/// shells.
constexpr int kFirstExitCode = 40;

std::optional<ErrorCode> CodeOfExit(int exit_code) {
  const int code = exit_code - kFirstExitCode;
  if (code < 0 || code > static_cast<int>(ErrorCode::kCancelled)) return std::nullopt;
  return static_cast<ErrorCode>(code);
}

}  // namespace

int ExitCodeOf(ErrorCode code) { return kFirstExitCode + static_cast<int>(code); }

Status CheckPictureBy(const PictureProcess& process, std::string_view picture,
                      const image::ImageLimits& limits, std::string_view name) {
  const auto refuse = [&](ErrorCode code, const std::string& why) {
    return Fail(code, fmt::format("{}: {}", name, why), std::string(name));
  };
  // Libraries, the file, and of each pixel 2 bytes; twice.
  constexpr std::uint64_t kLibraries = std::uint64_t{256} << 20;
  FileProcess reader;
  reader.time = process.time;
  reader.memory_bytes = kLibraries + 2 * (limits.max_file_bytes + 2 * limits.max_pixels +
                                          limits.max_decoder_bytes);
  reader.words = {process.program.string(), std::to_string(limits.max_file_bytes),
                  std::to_string(limits.max_pixels),
                  std::to_string(limits.max_decoder_bytes)};
  const auto end =
      INTAGLIO_TRY(RunOnFile(reader, std::as_bytes(std::span(picture)), name));
  if (end.is_too_long) {
    return refuse(
        ErrorCode::kTooLarge,
        fmt::format("decoding it took more than {} s of processor time; save it "
                    "again, with fewer pixels",
                    process.time.count()));
  }
  if (end.exit_code == 0) return {};
  if (const auto code = CodeOfExit(end.exit_code)) {
    const auto* text = reinterpret_cast<const char*>(end.output.data());
    return refuse(*code, std::string(text, end.output.size()));
  }
  return refuse(
      ErrorCode::kUnreadable,
      fmt::format("it crashed the reader of pictures ({}); the file is damaged, "
                  "save it again",
                  end.reason));
}

}  // namespace intaglio::reading
