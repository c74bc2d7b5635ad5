#pragma once

// The figures of a preview in words: the same in the picture, on the page and in the
// terminal.

#include <string>
#include <vector>

#include "proto/preview.pb.h"

namespace intaglio::client {

// Values of JobPreview.verdict.
inline constexpr const char* kReady = "ready";
inline constexpr const char* kReadyWithWarnings = "ready_with_warnings";
inline constexpr const char* kNeedsConsent = "needs_consent";
inline constexpr const char* kDraft = "draft";  ///< draft.h

/// "READY", ...; of one that needs a consent with the option that gives it.
std::string VerdictText(const JobPreview& figures);

struct PreviewLine {
  std::string label;  ///< "time"
  std::string value;  ///< "2 min 39 s at 100 Hz, after 30 s of lamp warm-up"
  bool bad = false;   ///< the glass may break
};

/// Piece, points, time, glass, machine; in this order. Of a draft what it has, of a job
/// of contours its contours in place of piece, points and glass.
std::vector<PreviewLine> LinesOf(const JobPreview& figures);

/// "40.4 x 31.3 x 39.9 mm".
std::string SizeText(const Vector3& size_mm);

}  // namespace intaglio::client
