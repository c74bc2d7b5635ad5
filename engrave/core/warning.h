#pragma once

// What a person should know of a piece before it is engraved: a warning has a code for
// programs, a weight that decides what follows from it, and a sentence with the remedy.
// Warnings go from the discretizer and the sorter through the job service to every
// client; services/job/verdict/warnings.h maps them to messages and back.
//
// Another warning: a value of WarningCode at the end, its row in warning.cc, and its row
// in docs/jobs.md ("Warnings"). Nothing else names codes.

#include <string>
#include <string_view>
#include <vector>

namespace intaglio {

/// In the order of what follows.
enum class WarningWeight {
  kNote,     ///< for information: nothing follows
  kWarning,  ///< the piece may look wrong: the verdict is "good, with warnings" at best
  kConsent,  ///< the block may be lost: a person has to accept it before the arm
};

enum class WarningCode {
  kOther,              ///< of a newer program, or a sentence that an older one left
  kChosen,             ///< what was chosen for the user, e.g. the size of the block
  kOpenSurface,        ///< edges of one triangle only
  kNonManifoldEdges,   ///< edges of more than two triangles
  kFlippedTriangles,   ///< oriented against their neighbours
  kOneSided,           ///< a part like a Moebius strip
  kInsideOut,          ///< the faces point inward
  kEmptyTriangles,     ///< triangles without an area
  kRepeatedTriangles,  ///< triangles that occur more than once
  kImplausibleSize,    ///< larger than the block, or tiny in it: a forgotten unit
  kLeftOut,            ///< what a drawing holds that is not engraved
  kParallelFaces,      ///< faces that no section cuts get no points
  kOddRays,            ///< rays cross a surface an odd number of times: it is not closed
  kThinForShells,      ///< points left out, where the model is too thin for its shells
  kDoubledPoints,      ///< several points at one place
  kNearPoints,         ///< points nearer than the minimum spacing
  kHole,               ///< a surface with a hole between its points
  kBreakage,           ///< cracks so dense that the glass may break
  kOrientation,        ///< upside down, on its back or flat, by a forgotten up axis
  kFallbackFont,       ///< characters in the letters of another font
  kTextShrunk,         ///< a text with smaller letters than the job asks for
  kFocusSpread,        ///< deep points whose focus is longer than a crack
  kObliqueBeam,        ///< points to which the beam is too oblique to make a crack
  kTwoFoci,            ///< points whose crack may begin at either of two depths
  kPulseHeat,          ///< pulses too weak for a crack, or so strong that they melt it
  kModelsOverlap,      ///< a text and models that lie in one another
  kSlowDepthAxis,      ///< a scan head waits for its z, by a narrow tolerance in depth
  kUntrustedPoints,    ///< whoever made points of the job was found wrong afterwards
};

struct Warning {
  WarningCode code = WarningCode::kOther;
  WarningWeight weight = WarningWeight::kNote;
  std::string text;  ///< one sentence: what, where, what to do

  bool operator==(const Warning&) const = default;
};

using Warnings = std::vector<Warning>;

/// A warning with the usual weight of its code.
Warning MakeWarning(WarningCode code, std::string text);

/// As programs read them: "odd_rays"; "note", "warning", "consent".
const char* WarningCodeName(WarningCode code);
const char* WarningWeightName(WarningWeight weight);
/// Of an unknown name: kOther, kNote.
WarningCode WarningCodeOf(std::string_view name);
WarningWeight WarningWeightOf(std::string_view name);

/// kNote when there is none.
WarningWeight GreatestWeight(const Warnings& warnings);

/// Those of at least this weight, the heaviest first, else in their order.
Warnings AtLeast(WarningWeight weight, const Warnings& warnings);

/// The first one that a person has to accept; nullptr: none.
const Warning* FindConsent(const Warnings& warnings);

}  // namespace intaglio
