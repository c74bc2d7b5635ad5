#include "services/client/job_view.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

#include "services/history/job_names.h"
#include "services/job/verdict/warnings.h"

namespace intaglio::client {

bool JobView::ended() const {
  return state == intaglio_JOB_DONE || state == intaglio_JOB_FAILED ||
         state == intaglio_JOB_CANCELLED;
}

namespace {

/// "waiting for arm" of "waiting_for_arm".
std::string SpacedOut(std::string_view state) {
  std::string words(state);
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

/// ", the lamp warms up" of "the lamp warms up: 17 %"; empty: it does not wait.
std::string WhatItWaitsFor(std::string_view message) {
  const std::string_view what = message.substr(0, message.find_first_of(":;\n"));
  return what.empty() ? "" : fmt::format(", {}", what);
}

bool IsState(std::string_view state, intaglio_JobState one) {
  return state == history::StateName(one);
}

}  // namespace

std::string NameOf(intaglio_JobState state) {
  return SpacedOut(history::StateName(state));
}

std::string StateOf(std::string_view state, bool armed, std::string_view message) {
  const bool ended = IsState(state, intaglio_JOB_DONE) ||
                     IsState(state, intaglio_JOB_FAILED) ||
                     IsState(state, intaglio_JOB_CANCELLED);
  if (!armed || ended || IsState(state, intaglio_JOB_ENGRAVING)) return SpacedOut(state);
  if (IsState(state, intaglio_JOB_WAITING_FOR_ARM))
    return "armed" + WhatItWaitsFor(message);
  return SpacedOut(state) + ", armed";
}

std::string StateOf(const JobView& job) {
  return StateOf(history::StateName(job.state), job.armed, job.message);
}

std::string SpeedNote(std::uint32_t speed_percent) {
  return speed_percent == 100 ? "" : fmt::format("at {} % speed", speed_percent);
}

std::string ArmCommandOf(const JobView& job) {
  const Warning* consent = job.open_consent();
  return fmt::format("intaglio arm {}{}", job.number,
                     consent == nullptr ? "" : " " + AcceptOption(*consent));
}

const JobView::Progress* StageAtWork(const JobView& job) {
  for (const JobView::Progress& p : job.progress) {
    if (!p.ended()) return &p;
  }
  return job.progress.empty() ? nullptr : &job.progress.back();
}

const char* NameOf(intaglio_Stage stage) {
  switch (stage) {
    case intaglio_STAGE_DISCRETIZE:
      return "discretize";
    case intaglio_STAGE_SORT:
      return "order";
    case intaglio_STAGE_ENGRAVE:
      return "engrave";
  }
  return "unknown";
}

const char* NameOf(intaglio_CommandAnswerCode code) {
  switch (code) {
    case intaglio_ANSWER_TAKEN:
      return "taken";
    case intaglio_ANSWER_UNKNOWN_JOB:
      return "unknown_job";
    case intaglio_ANSWER_WRONG_EPOCH:
      return "wrong_epoch";
    case intaglio_ANSWER_ENDED_JOB:
      return "ended_job";
    case intaglio_ANSWER_NOT_YET:
      return "not_yet";
    case intaglio_ANSWER_SUPERSEDED:
      return "superseded";
    case intaglio_ANSWER_STOP_PRESSED:
      return "stop_pressed";
    case intaglio_ANSWER_OUT_OF_RANGE:
      return "out_of_range";
    case intaglio_ANSWER_NEEDS_CONSENT:
      return "needs_consent";
    case intaglio_ANSWER_SAME_BLOCK:
      return "same_block";
    case intaglio_ANSWER_NOT_MOUNTED:
      return "not_mounted";
    case intaglio_ANSWER_NOT_LEFT_OUT:
      return "not_left_out";
    case intaglio_ANSWER_UNDECIDED:
      return "undecided";
    case intaglio_ANSWER_TOO_MANY:
      return "too_many";
  }
  return "unknown";
}

std::string OperatorName() {
  char host[256] = "localhost";
  gethostname(host, sizeof host - 1);
  const char* user = std::getenv("USER");
  return fmt::format("{}@{}", user != nullptr ? user : "operator", host);
}

}  // namespace intaglio::client
