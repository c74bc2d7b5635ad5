#pragma once

#include <string>

#include "services/client/job_view.h"

namespace intaglio::client {

/// What a person has to do before the job goes on, with the command; empty: nothing.
/// Status, list, show and watch print this, and the exit code of status follows from it.
///
/// clang-format off
///   not armed, its warning needs a consent    arm it with the consent, or cancel
///   not armed, waits for its arm              put in the block, arm it
///   not armed, paused                         resume or cancel
///   the same, with uncertain points           check the block, resume with or without
///   them armed, ended, or before its machine       nothing: it goes on by itself
/// clang-format on
std::string NeedOf(const JobView& job);

/// The state of a job that was submitted or paused, and what is next: what a person has
/// to do; else its state with the reason, and the arm that a queued job needs once it has
/// its machine.
std::string StateAndNextOf(const JobView& job);

}  // namespace intaglio::client
