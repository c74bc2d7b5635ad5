#include "services/cli/progress/progress_bar.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <vector>

#include "services/cli/progress/time_left.h"
#include "services/client/figure_text.h"

namespace intaglio::cli {
namespace {
constexpr int kBarWidth = 24;
constexpr const char* kBetween = "  ";
constexpr int kKept = 10;  // the worth of what is cut rather than dropped

/// A part of the line; what is dropped first has the smallest worth.
struct Part {
  std::string text;
  int worth = 0;
};

/// Counts a column for each character of UTF-8 text.
std::size_t WidthOf(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

/// Its first columns, with "..." at the end when something is cut off.
std::string CutTo(std::size_t columns, std::string text) {
  if (WidthOf(text) <= columns) return text;
  const std::string dots(std::min<std::size_t>(3, columns), '.');
  while (!text.empty() && WidthOf(text) + dots.size() > columns) {
    while (text.size() > 1 && (text.back() & 0xC0) == 0x80) text.pop_back();
    text.pop_back();
  }
  return text + dots;
}

std::string Joined(const std::vector<Part>& parts) {
  std::string line;
  for (const Part& part : parts) {
    if (part.text.empty()) continue;
    line += (line.empty() ? "" : kBetween) + part.text;
  }
  return line;
}

/// Without the parts of smallest worth, as far as they make it too wide.
std::string Fit(std::vector<Part> parts, std::size_t columns) {
  while (WidthOf(Joined(parts)) > columns) {
    const auto cheapest =
        std::min_element(parts.begin(), parts.end(),
                         [](const Part& a, const Part& b) { return a.worth < b.worth; });
    if (cheapest->worth >= kKept) break;
    parts.erase(cheapest);
  }
  return CutTo(columns, Joined(parts));
}

/// "the lamp warms up: 17 %" without its figures: a log should have each note once.
std::string WithoutDigits(std::string text) {
  std::erase_if(text, [](char c) { return c >= '0' && c <= '9'; });
  return text;
}
}  // namespace

int ColumnsOfTerminal() {
  winsize size = {};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}

ProgressBar::ProgressBar(std::ostream& out, bool interactive, ProgressSurroundings around)
    : out_(out), interactive_(interactive), around_(std::move(around)) {}

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
    // The last column stays free: a character in it would wrap the line.
    const int columns = around_.columns();
    const std::string line =
        Line(columns > 1 ? static_cast<std::size_t>(columns - 1) : 0);
    const std::size_t width = WidthOf(line);
    const std::size_t blank = drawn_width_ > width ? drawn_width_ - width : 0;
    out_ << '\r' << line << std::string(blank, ' ') << std::flush;
    drawn_width_ = width;
    return;
  }
  const int tenth = total == 0 ? 0 : static_cast<int>(10 * done / total);
  const std::string words = WithoutDigits(note);
  if (tenth == shown_tenth_ && words == shown_note_) return;
  shown_tenth_ = tenth;
  shown_note_ = words;
  out_ << Line(0) << '\n' << std::flush;
}

std::string ProgressBar::Line(std::size_t columns) const {
  const double share =
      total_ == 0
          ? 0
          : std::min(1.0, static_cast<double>(done_) / static_cast<double>(total_));
  const int full = static_cast<int>(share * kBarWidth);
  const std::string percent = fmt::format("{:3.0f} %", 100 * share);
  const std::string bar = fmt::format("{:<10} [{:#<{}}{:-<{}}] {}", stage_, "", full, "",
                                      kBarWidth - full, percent);
  const std::string head = fmt::format("{:<10} {}", stage_, percent);
  std::string counts, rate;
  if (total_ > 0 && in_points_) {
    counts = fmt::format("{} / {} {}", client::GroupedDigits(done_),
                         client::GroupedDigits(total_), things_);
  }
  if (done_ > 0 && elapsed_s_ > 0 && in_points_) {
    rate = client::ShortNumber(static_cast<double>(done_) / elapsed_s_) + "/s";
  }
  const auto [left, ends] =
      TimeLeftOf(client::WorkLeftOf(share, elapsed_s_, expected_s_), around_.now());
  const std::vector<Part> after = {
      {counts, 2}, {rate, 1}, {left, kKept}, {ends, 3}, {note_, kKept}};
  const auto with = [&after](const std::string& begin) {
    std::vector<Part> parts = {{begin, kKept}};
    parts.insert(parts.end(), after.begin(), after.end());
    return parts;
  };
  const std::string whole = Joined(with(bar));
  return columns == 0 || WidthOf(whole) <= columns ? whole : Fit(with(head), columns);
}

void ProgressBar::Finish() {
  if (interactive_ && drawn_width_ > 0) out_ << '\n' << std::flush;
  drawn_width_ = 0;
  stage_.clear();
}

}  // namespace intaglio::cli
