#pragma once

// Which print mark begins which repeat, by what the photo eye before a scan head has
// seen. Places are those of the web's encoder, mm, up when the web moves along +x.
//
// A print mark counts when it lies a pitch behind another one: that finds the print at
// the begin of a run, in which nothing seen before it is used. From then on the next is
// expected a pitch behind the last, within the tolerance; behind n that are missing, n +
// 1 pitches. What lies elsewhere is ignored and counted. A web that has passed the window
// of a print mark without one has it missing, and more in a row than may be end the print
// for this run.

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "services/drivers/interface/print_eye.h"

namespace intaglio::drivers {

class PrintTracker {
 public:
  enum class State : std::uint8_t { kAwaited, kSeen, kMissing, kLost };

  /// What another session or power-up saw is forgotten.
  void Forget();
  /// A run of these repeats; its web is at the newest place.
  void Begin(const PrintEye& eye);

  /// An edge has passed the eye, in the order of the edges; before the begin of the run
  /// it is not used.
  void See(double place_mm, bool in_run = true);
  /// The web is here, and every edge that has passed by then was seen.
  void PassTo(double place_mm);

  State StateOf(std::uint32_t repeat) const;
  /// Of a repeat that is kSeen: where its print mark passed.
  double PlaceOf(std::uint32_t repeat) const;
  /// Why a repeat is kLost, with the remedy.
  std::string LossText() const;

  /// In this run, away from expected places.
  std::uint32_t ignored_count() const { return ignored_; }

 private:
  bool LiesAPitchBehindAnother(double place_mm) const;
  void Receive(double place_mm);
  /// Of the print mark that is expected next.
  double ExpectedMm() const { return last_mm_ + (missing_in_a_row_ + 1) * eye_.pitch_mm; }

  PrintEye eye_;
  std::deque<double> recent_mm_;  // also before the run
  double now_mm_ = 0, begin_mm_ = 0;
  bool found_ = false;  // the print, in this run
  bool lost_ = false;
  double last_mm_ = 0;
  std::uint32_t missing_in_a_row_ = 0;
  std::vector<std::optional<double>> places_mm_;  // from eye_.first_repeat on
  std::uint32_t ignored_ = 0;
};

}  // namespace intaglio::drivers
