#pragma once

// What the reader of a file met and did not obey, in the one form that all readers use:
// what it is, where it first is, how often, and the effect on the piece. The effect alone
// decides what follows, and it decides so in this place for every format:
//
//   effect            follows
//   kNothingSeen      a note: hidden by the file itself, or of a look that has no lines
//   kLost             a warning: seen in the file, missed in the piece
//   kChanged          a warning: in the piece, but not as in the file
//   kMeaningLost      the file is refused: everything else in it may be wrong without it
//
// A reader states an effect for every element of its grammar that it does not obey. What
// no reader knows is kLost: a new element of a format is never lost in silence.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/core/warning.h"

namespace intaglio {

enum class Effect { kNothingSeen, kLost, kChanged, kMeaningLost };

struct FileFinding {
  std::string what;         ///< the element or command, printable: "clip-path", "TEXT"
  std::string where;        ///< of the first one: "line 12"; empty: not known
  std::string remedy;       ///< "convert them to curves"; empty: none is known
  std::uint64_t count = 0;  ///< how many were met
  /// The part of the drawing's area that is concerned, mm^2, summed; 0: not known.
  double area_mm2 = 0;
  Effect effect = Effect::kLost;
  /// Several of `what`, where it is words, not a name of the format: "vertices of no
  /// face"; empty: it is shown as "3 x TEXT".
  std::string plural = {};

  bool operator==(const FileFinding&) const = default;
};

/// The findings of one file, one of each name and effect, in the order in which they were
/// met. A file cannot fill the memory with them: names are cut after 60 bytes and shown
/// with "?" for what is not printable, and behind 64 names all are "other".
class FileFindings {
 public:
  void Add(FileFinding finding);

  /// Whether Add would keep the place of such a finding: for places that cost time.
  bool IsNew(std::string_view what, Effect effect) const;
  /// How many of this name were met, of every effect; 0: none.
  std::uint64_t CountOf(std::string_view what) const;
  bool empty() const { return all_.empty(); }
  std::size_t size() const { return all_.size(); }
  auto begin() const { return all_.begin(); }
  auto end() const { return all_.end(); }

  bool operator==(const FileFindings&) const = default;

 private:
  std::vector<FileFinding> all_;
};

/// kUnsupported with the first finding whose effect is kMeaningLost; `file` is what
/// errors call the file.
Status CheckMeaning(std::string_view file, const FileFindings& findings);

/// One warning a finding, of the code kLeftOut and with the weight of its effect.
Warnings WarningsOf(std::string_view file, const FileFindings& findings);

}  // namespace intaglio
