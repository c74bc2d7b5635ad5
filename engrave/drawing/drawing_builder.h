#pragma once

// The part common to the readers: names, limits, and the first error.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>

#include "engrave/core/result.h"
#include "engrave/drawing/drawing.h"

namespace intaglio::drawing {

/// What helps where a file has something else than curves.
inline constexpr std::string_view kConvertToCurves =
    "convert them to curves if they have to be engraved";

/// Collects the curves of a file. Every function that may fail returns false and keeps
/// the first error; the reader then unwinds.
class DrawingBuilder {
 public:
  /// `name` is what errors call the file.
  DrawingBuilder(std::string_view name, const DrawingLimits& limits)
      : name_(name), limits_(limits) {}

  /// Error "<name>, <place>: <sentence>". Always false.
  bool Refuse(ErrorCode code, std::string_view place, std::string_view sentence,
              std::string_view value = {});

  /// Refuses a file that is larger than the limit.
  bool CheckSize(std::uint64_t bytes);
  /// Counts one entity of the limit: each curve, each insertion, each reference.
  bool CountEntity(std::string_view place);
  /// Counts bytes that are read again because of a block or reference.
  bool CountUnfolded(std::uint64_t bytes, std::string_view place);
  /// Counts points before they are stored.
  bool CountPoints(std::uint64_t points, std::string_view place);

  /// Adds a curve that CountEntity counted; curves without pieces are skipped. Its
  /// numbers must be finite and within reach.
  bool Add(Curve curve, std::string_view place);

  /// The index of the name; names longer than 255 bytes are cut.
  std::uint32_t NameIndex(std::string_view name);

  /// Records an entity of this kind that is not obeyed (core/findings.h).
  void LeaveOut(std::string_view kind, Effect effect, std::string_view place = {},
                double area_mm2 = 0, std::string_view remedy = kConvertToCurves);

  /// The same; `place()` is called for the first of a kind alone.
  template <typename Place>
  void LeaveOutAt(std::string_view kind, Effect effect, const Place& place,
                  double area_mm2 = 0, std::string_view remedy = kConvertToCurves) {
    const bool is_new = drawing_.findings.IsNew(kind, effect);
    LeaveOut(kind, effect, is_new ? place() : std::string(), area_mm2, remedy);
  }

  /// Records that the job's unit, if it has one, replaces the unit of `whose` (a page).
  void NoteUnitAskedFor(std::string_view whose, std::optional<double> unit_mm);

  /// Drawing::unit_mm.
  void SetUnit(double unit_mm) { drawing_.unit_mm = unit_mm; }

  std::uint64_t unfolded_bytes() const { return unfolded_bytes_; }
  const DrawingLimits& limits() const { return limits_; }

  /// The drawing or the first error.
  Result<Drawing> Take();

 private:
  std::string name_;
  DrawingLimits limits_;
  Drawing drawing_;
  std::unordered_map<std::string, std::uint32_t> name_index_;
  std::uint64_t entities_ = 0;
  std::uint64_t unfolded_bytes_ = 0;
  std::uint64_t points_ = 0;
  std::optional<Error> error_;
};

/// At most `max_bytes` of a text that an error shows, with what is not printable as "?".
std::string Shown(std::string_view text, std::size_t max_bytes = 40);

/// A decimal number that is the whole text, except for surrounding blanks and a plus
/// sign. A value that is not finite is not accepted.
std::optional<double> NumberOf(std::string_view text);

}  // namespace intaglio::drawing
