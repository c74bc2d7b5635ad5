#include "services/cli/progress/progress_bar.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ostream>

#include "services/client/figure_text.h"

namespace intaglio::cli {
namespace {
constexpr int kBarWidth = 24;
constexpr double kPaceIsKnown = 0.05;

/// "the lamp warms up: 17 %" without its figures: a log should have each note once.
std::string WithoutDigits(std::string text) {
  std::erase_if(text, [](char c) { return c >= '0' && c <= '9'; });
  return text;
}
}  // namespace

ProgressBar::ProgressBar(std::ostream& out, bool interactive)
    : out_(out), interactive_(interactive) {}

void ProgressBar::Show(const std::string& stage, std::uint64_t done, std::uint64_t total,
                       double elapsed_s, const std::string& note) {
  in_points_ = true;
  Draw(stage, done, total, elapsed_s, note);
}

void ProgressBar::ShowShare(const std::string& stage, std::uint64_t done,
                            std::uint64_t total, double elapsed_s,
                            const std::string& note) {
  in_points_ = false;
  Draw(stage, done, total, elapsed_s, note);
}

void ProgressBar::Draw(const std::string& stage, std::uint64_t done, std::uint64_t total,
                       double elapsed_s, const std::string& note) {
  if (stage != stage_) {
    Finish();
    stage_ = stage;
    shown_tenth_ = -1;
    shown_note_.clear();
  }
  done_ = done;
  total_ = total;
  elapsed_s_ = elapsed_s;
  note_ = note;
  if (interactive_) {
    const std::string line = Line();
    const std::size_t blank = drawn_width_ > line.size() ? drawn_width_ - line.size() : 0;
    out_ << '\r' << line << std::string(blank, ' ') << std::flush;
    drawn_width_ = line.size();
    return;
  }
  const int tenth = total == 0 ? 0 : static_cast<int>(10 * done / total);
  const std::string words = WithoutDigits(note);
  if (tenth == shown_tenth_ && words == shown_note_) return;
  shown_tenth_ = tenth;
  shown_note_ = words;
  out_ << Line() << '\n' << std::flush;
}

double ProgressBar::SecondsLeft(double share) const {
  if (share < kPaceIsKnown && expected_s_ > 0) return expected_s_ * (1 - share);
  return share > 0 && elapsed_s_ > 0 ? elapsed_s_ * (1 - share) / share : -1;
}

std::string ProgressBar::Line() const {
  const double share =
      total_ == 0
          ? 0
          : std::min(1.0, static_cast<double>(done_) / static_cast<double>(total_));
  const int full = static_cast<int>(share * kBarWidth);
  std::string line = fmt::format("{:<11}[{:#<{}}{:-<{}}] {:3.0f} %", stage_, "", full, "",
                                 kBarWidth - full, 100 * share);
  if (total_ > 0 && in_points_) {
    line += fmt::format("  {} / {} {}", client::GroupedDigits(done_),
                        client::GroupedDigits(total_), things_);
  }
  if (done_ > 0 && elapsed_s_ > 0) {
    const double rate = static_cast<double>(done_) / elapsed_s_;
    if (in_points_) line += fmt::format("  {}/s", client::ShortNumber(rate));
    const double left_s = SecondsLeft(share);
    if (total_ > done_ && left_s >= 0) {
      line += fmt::format("  {} left", client::ShortDuration(left_s));
    }
  }
  return note_.empty() ? line : line + "  " + note_;
}

void ProgressBar::Finish() {
  if (interactive_ && drawn_width_ > 0) out_ << '\n' << std::flush;
  drawn_width_ = 0;
  stage_.clear();
}

}  // namespace intaglio::cli
