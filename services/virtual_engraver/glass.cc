#include "services/virtual_engraver/glass.h"

#include <fmt/format.h>

#include <cmath>

namespace intaglio::virtual_engraver {
namespace {

tl::unexpected<Error> CannotWrite(const std::filesystem::path& file) {
  return Fail(ErrorCode::kIo,
              fmt::format("cannot write the glass record {}: free space on the disk",
                          file.string()),
              file.string());
}

}  // namespace

double CrackLengthMm(double full_mm, double energy_ratio) {
  return full_mm * std::cbrt(energy_ratio);
}

Result<Glass> Glass::Create(const std::filesystem::path& file,
                            const formats::GlassHeader& header) {
  std::ofstream out(file, std::ios::binary | std::ios::trunc);
  const auto head = formats::EncodeGlassHeader(header);
  out.write(reinterpret_cast<const char*>(head.data()),
            static_cast<std::streamsize>(head.size()));
  out.flush();
  if (!out) return CannotWrite(file);
  return Glass(file, std::move(out));
}

void Glass::Add(const formats::GlassCrack& crack) {
  formats::AppendGlassCrack(crack, unwritten_);
  ++crack_count_;
}

void Glass::Add(const formats::GlassCollision& collision) {
  formats::AppendGlassCollision(collision, unwritten_);
}

Status Glass::Flush() {
  if (unwritten_.empty()) return {};
  const auto before = out_.tellp();
  out_.write(reinterpret_cast<const char*>(unwritten_.data()),
             static_cast<std::streamsize>(unwritten_.size()));
  out_.flush();
  if (!out_) {
    out_.clear();
    out_.seekp(before);
    return CannotWrite(path_);
  }
  unwritten_.clear();
  return {};
}

}  // namespace intaglio::virtual_engraver
