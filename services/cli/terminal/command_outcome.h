#pragma once

// What a command reports. A person reads sentences as they come. With --json a program
// reads one object on the standard output: the message of the command if it has one of
// its own (docs/cli.md), else a CommandAnswer (proto/console.proto) with the sentences
// that would have been printed. A command that is not carried out always prints a
// CommandAnswer with a code (services/client/refusal_code.h). With --events what is
// refused before any event is an event `refused` with that code, beside the sentence for
// people on the standard error stream. The exit code is the same in each form.
//
//   Complain, std::cout -> CommandOutcome --(--json)--> CommandAnswer
//                                         --(--events)--> JobEvent `refused`
//                                         --(people)--> the streams themselves
//
// One thread runs a command, and it alone calls these.

#include <cstdint>
#include <functional>

#include "engrave/core/result.h"
#include "proto/shop.pb.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// The job that the running command is about. Of several the answer has the list, and 0
/// as its job.
void ReportJob(std::uint32_t number);

/// An error that ends the command, or a part of what it was to do. It becomes a part of
/// the CommandAnswer, or a sentence on the standard error stream: for a person, and where
/// the standard output has the command's own message already. Without a message: it was
/// printed before, and only the answer needs its code.
void ReportRefusal(const Error& error);

/// The event of a refusal, for a command that has written events already and goes on or
/// ends without an event of its own.
JobEvent RefusedEventOf(const Error& error);

/// The text of the running command becomes that of the CommandAnswer. It is called by a
/// command with a message of its own that does not print it with the given options.
void AnswerWithText();

/// Gives --json to every command of the program that has none of its own, and makes what
/// is refused with --json a CommandAnswer. To be called when all commands are there.
void AnswerInJson(command_line::Program& program);

/// Why this command has no --json; nullptr: it has.
const char* ReasonForNoJson(const std::string& command);

}  // namespace intaglio::cli
