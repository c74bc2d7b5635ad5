#include "engrave/drawing/drawing_builder.h"

#include <fmt/format.h>

#include "engrave/core/try.h"
#include "engrave/drawing/pieces.h"
#include "engrave/io/number_text.h"

namespace intaglio::drawing {
namespace {

constexpr std::size_t kMaxNameBytes = 255;

bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

}  // namespace

bool DrawingBuilder::Refuse(ErrorCode code, std::string_view place,
                            std::string_view sentence, std::string_view value) {
  if (!error_) {
    error_ = Error{code,
                   place.empty() ? fmt::format("{}: {}", name_, sentence)
                                 : fmt::format("{}, {}: {}", name_, place, sentence),
                   Shown(value)};
  }
  return false;
}

bool DrawingBuilder::CheckSize(std::uint64_t bytes) {
  if (bytes <= limits_.max_file_bytes) return true;
  return Refuse(ErrorCode::kTooLarge, "",
                fmt::format("the file has {} bytes, the limit is {}; divide the drawing "
                            "or raise the limit",
                            bytes, limits_.max_file_bytes));
}

bool DrawingBuilder::CountEntity(std::string_view place) {
  if (++entities_ <= limits_.max_entities) return true;
  return Refuse(ErrorCode::kTooLarge, place,
                fmt::format("more than {} entities after blocks and references are "
                            "expanded; divide the drawing or raise the limit",
                            limits_.max_entities));
}

bool DrawingBuilder::CountUnfolded(std::uint64_t bytes, std::string_view place) {
  unfolded_bytes_ += bytes;
  if (unfolded_bytes_ <= limits_.max_unfolded_bytes) return true;
  return Refuse(ErrorCode::kTooLarge, place,
                fmt::format("blocks or references expand to more than {} bytes; explode "
                            "them in the drawing program or raise the limit",
                            limits_.max_unfolded_bytes));
}

bool DrawingBuilder::CountPoints(std::uint64_t points, std::string_view place) {
  points_ += points;
  if (points_ <= limits_.max_points) return true;
  return Refuse(ErrorCode::kTooLarge, place,
                fmt::format("more than {} points; divide the drawing or raise the limit",
                            limits_.max_points));
}

bool DrawingBuilder::Add(Curve curve, std::string_view place) {
  if (curve.pieces.empty()) return true;
  std::uint64_t points = 0;
  for (const Piece& piece : curve.pieces) {
    points += PointCountOf(piece);
    if (!WithinReach(piece, limits_.max_coordinate_mm)) {
      return Refuse(ErrorCode::kInvalidValue, place,
                    fmt::format("a coordinate is farther from the origin than {} mm; "
                                "check the unit and the scale of blocks and groups",
                                limits_.max_coordinate_mm));
    }
  }
  if (!CountPoints(points, place)) return false;
  drawing_.curves.push_back(std::move(curve));
  return true;
}

std::uint32_t DrawingBuilder::NameIndex(std::string_view name) {
  if (name.empty()) return 0;
  std::string key(name.substr(0, kMaxNameBytes));
  const auto next = static_cast<std::uint32_t>(drawing_.names.size());
  const auto [found, is_new] = name_index_.try_emplace(std::move(key), next);
  if (is_new) drawing_.names.push_back(found->first);
  return found->second;
}

void DrawingBuilder::NoteUnitAskedFor(std::string_view whose,
                                      std::optional<double> unit_mm) {
  if (!unit_mm) return;
  LeaveOut(fmt::format("unit of the {} ({:g} mm as asked for)", whose, *unit_mm),
           Effect::kNothingSeen);
}

void DrawingBuilder::LeaveOut(std::string_view kind, Effect effect,
                              std::string_view place, double area_mm2,
                              std::string_view remedy) {
  drawing_.findings.Add(
      {.what = std::string(kind),
       .where = std::string(place),
       .remedy = effect == Effect::kNothingSeen ? std::string() : std::string(remedy),
       .count = 1,
       .area_mm2 = area_mm2,
       .effect = effect});
}

Result<Drawing> DrawingBuilder::Take() {
  if (error_) return tl::unexpected(std::move(*error_));
  INTAGLIO_TRY(CheckMeaning(name_, drawing_.findings));
  return std::move(drawing_);
}

std::string Shown(std::string_view text, std::size_t max_bytes) {
  std::string shown(text.substr(0, max_bytes));
  for (char& c : shown) {
    if (c < ' ' || c > '~') c = '?';
  }
  if (text.size() > max_bytes) shown += "...";
  return shown;
}

std::optional<double> NumberOf(std::string_view text) {
  while (!text.empty() && IsBlank(text.front())) text.remove_prefix(1);
  while (!text.empty() && IsBlank(text.back())) text.remove_suffix(1);
  return io::ParseFinite(text);
}

}  // namespace intaglio::drawing
