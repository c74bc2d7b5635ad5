#include "services/job_service/records/job_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "services/platform/host/stage/task_part.h"

namespace intaglio::job_service {
namespace {

constexpr std::uint32_t kPartsPerDiscretizer = 8;

// Units in which the progress of a part is published: parts count their work each in
// units of its own.
constexpr std::uint64_t kPartUnits = 1000;

std::uint64_t UnitsDone(const PartRecord& part) {
  if (part.done) return kPartUnits;
  if (part.total_count == 0) return 0;
  return std::min(kPartUnits, kPartUnits * part.done_count / part.total_count);
}

PartRecord AnotherAttempt(const PartRecord& part) {
  PartRecord open;
  open.attempt = part.attempt + 1;
  open.losses = part.losses;
  return open;
}

}  // namespace

std::uint32_t PartCountFor(std::size_t discretizers) {
  if (discretizers <= 1) return 1;
  return static_cast<std::uint32_t>(
      std::min<std::size_t>(host::kMaxParts, kPartsPerDiscretizer * discretizers));
}

void JobParts::Cut(std::size_t discretizers, Nanoseconds now) {
  parts_.assign(PartCountFor(discretizers), {});
  last_loss_.clear();
  begun_at_ = now;
}

void JobParts::Restore(std::uint32_t part, std::uint32_t attempt,
                       const std::string& worker) {
  if (part >= parts_.size()) parts_.resize(part + 1);
  parts_[part].attempt = attempt;
  parts_[part].worker = worker;
}

std::optional<std::uint32_t> JobParts::NextOpen(Nanoseconds now) const {
  for (std::uint32_t i = 0; i < parts_.size(); ++i) {
    if (parts_[i].open() && now >= parts_[i].not_before) return i;
  }
  return std::nullopt;
}

std::optional<std::uint32_t> JobParts::NextAhead() const {
  std::set<std::string> at_work;
  std::size_t open_count = 0;
  std::optional<std::uint32_t> next;
  for (std::uint32_t i = 0; i < parts_.size(); ++i) {
    const PartRecord& part = parts_[i];
    if (part.at_work()) at_work.insert(part.worker);
    if (!part.open()) continue;
    ++open_count;
    if (!next && part.attempt == 0) next = i;
  }
  return open_count > at_work.size() ? next : std::nullopt;
}

void JobParts::Give(std::uint32_t part, const std::string& worker) {
  parts_.at(part).worker = worker;
}

bool JobParts::IsCurrent(const std::string& worker, std::uint32_t part,
                         std::uint32_t attempt) const {
  if (part >= parts_.size()) return false;
  const PartRecord& record = parts_[part];
  return record.worker == worker && record.attempt == attempt && !record.done;
}

void JobParts::SetProgress(std::uint32_t part, std::uint64_t done_count,
                           std::uint64_t total_count) {
  parts_.at(part).done_count = done_count;
  parts_.at(part).total_count = total_count;
}

void JobParts::Finish(std::uint32_t part) { parts_.at(part).done = true; }

void JobParts::Lose(std::uint32_t part, const std::string& why, Nanoseconds not_before) {
  PartRecord& record = parts_.at(part);
  record = AnotherAttempt(record);
  ++record.losses;
  record.not_before = not_before;
  last_loss_ = fmt::format("{} starts again: {}", NameOf(part), why);
}

void JobParts::LoseAhead(std::uint32_t part) {
  parts_.at(part) = AnotherAttempt(parts_.at(part));
}

bool JobParts::all_done() const {
  return std::all_of(parts_.begin(), parts_.end(),
                     [](const PartRecord& part) { return part.done; });
}

bool JobParts::any_at_work() const {
  return std::any_of(parts_.begin(), parts_.end(),
                     [](const PartRecord& part) { return part.at_work(); });
}

std::string JobParts::NameOf(std::uint32_t part) const {
  return fmt::format("part {} of {}", part + 1, parts_.size());
}

JobParts::Progress JobParts::ProgressAt(Nanoseconds now) const {
  Progress progress;
  progress.elapsed_s = std::chrono::duration<double>(now - begun_at_).count();
  if (all_done()) {
    for (const PartRecord& part : parts_) progress.done_count += part.total_count;
    progress.total_count = progress.done_count;
    return progress;
  }
  for (const PartRecord& part : parts_) progress.done_count += UnitsDone(part);
  progress.total_count = kPartUnits * parts_.size();
  progress.done_count = std::min(progress.done_count, progress.total_count - 1);
  return progress;
}

}  // namespace intaglio::job_service
