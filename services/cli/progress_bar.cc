#include "services/cli/progress_bar.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ostream>

namespace intaglio::cli {
namespace {
constexpr int kBarWidth = 24;

/// "the lamp warms up: 17 %" without its figures: a log wants each thing told once.
std::string WithoutDigits(std::string text) {
  std::erase_if(text, [](char c) { return c >= '0' && c <= '9'; });
  return text;
}
}  // namespace

std::string GroupedDigits(std::uint64_t number) {
  std::string digits = std::to_string(number);
  for (int at = static_cast<int>(digits.size()) - 3; at > 0; at -= 3) {
    digits.insert(static_cast<std::size_t>(at), " ");
  }
  return digits;
}

std::string ShortNumber(double number) {
  if (number >= 1e6) return fmt::format("{:.2f} M", number / 1e6);
  if (number >= 1e4) return fmt::format("{:.0f} k", number / 1e3);
  return number >= 100 ? fmt::format("{:.0f} ", number) : fmt::format("{:.1f} ", number);
}

std::string ShortDuration(double seconds) {
  if (!(seconds >= 0) || seconds > 1e8) return "?";
  if (seconds < 10) return fmt::format("{:.1f} s", seconds);
  const auto whole = static_cast<std::uint64_t>(std::llround(seconds));
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole % 3600 / 60);
}

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
    told_tenth_ = -1;
    told_note_.clear();
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
  if (tenth == told_tenth_ && words == told_note_) return;
  told_tenth_ = tenth;
  told_note_ = words;
  out_ << Line() << '\n' << std::flush;
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
    line += fmt::format("  {} / {} points", GroupedDigits(done_), GroupedDigits(total_));
  }
  if (done_ > 0 && elapsed_s_ > 0) {
    const double rate = static_cast<double>(done_) / elapsed_s_;
    if (in_points_) line += fmt::format("  {}/s", ShortNumber(rate));
    if (total_ > done_) {
      line += fmt::format("  {} left",
                          ShortDuration(static_cast<double>(total_ - done_) / rate));
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
