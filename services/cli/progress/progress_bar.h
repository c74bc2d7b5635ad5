#pragma once

// A line on the terminal that shows how far a stage is: share, points, rate, time left,
// and for more than a minute also the clock time of the end.
//   order      [##########----------]  52 %  41 230 / 79 100 points  1.2 M/s  3 s left
//   engrave    [##########----------]  52 %  120 /s  7 min 02 s left  ends 14:32
// On a terminal the line is drawn over and is no wider than the terminal: the bar goes
// first, then the rate, the counts, the clock time, and a note that is too long ends in
// "...". Elsewhere (a log, a pipe) a line is printed at the stage's begin, at each tenth,
// at its end, and when the note's text changes.

#include <chrono>
#include <cstdint>
#include <ctime>
#include <functional>
#include <iosfwd>
#include <string>
#include <utility>

namespace intaglio::cli {

/// The columns of the terminal of the standard error stream; 0: it is none, or unknown.
int ColumnsOfTerminal();

/// What a bar asks of the computer; tests give other answers.
struct ProgressSurroundings {
  std::function<int()> columns = ColumnsOfTerminal;  ///< 0: as wide as a line is
  std::function<std::time_t()> now = [] { return std::time(nullptr); };
};

class ProgressBar {
 public:
  /// `interactive`: the stream is a terminal.
  ProgressBar(std::ostream& out, bool interactive, ProgressSurroundings around = {});

  /// What is counted, in the plural; default points.
  void CountIn(std::string things) { things_ = std::move(things); }
  /// A new stage begins when `stage` differs from the last call's. total 0: unknown.
  void Show(const std::string& stage, std::uint64_t done, std::uint64_t total,
            double elapsed_s, const std::string& note = {});
  /// The same for work that is not counted in points: no counts and no rate.
  void ShowShare(const std::string& stage, std::uint64_t done, std::uint64_t total,
                 double elapsed_s, const std::string& note = {});
  /// How long the stage takes in all, s, as planned; 0: not known. It decides the time
  /// left until the pace is known from a twentieth of the work.
  void Expect(double total_s) { expected_s_ = total_s; }
  /// Ends the line in hand.
  void Finish();

 private:
  void Draw(const std::string& stage, std::uint64_t done, std::uint64_t total,
            double elapsed_s, const std::string& note);
  /// No wider than this; 0: as wide as it is.
  std::string Line(std::size_t columns) const;
  std::ostream& out_;
  bool interactive_;
  ProgressSurroundings around_;
  std::string things_ = "points";
  std::string stage_, note_;
  std::uint64_t done_ = 0, total_ = 0;
  double elapsed_s_ = 0;
  double expected_s_ = 0;
  bool in_points_ = true;
  int shown_tenth_ = -1;
  std::string shown_note_;
  std::size_t drawn_width_ = 0;
};

}  // namespace intaglio::cli
