#pragma once

#include <string>

#include "engrave/core/result.h"

namespace intaglio::client {

/// The `code` of a CommandAnswer for a command that was not carried out: the answer of a
/// job service ("superseded", with which JobClient::Command fails), else the name of the
/// error's code ("not_found"). docs/cli.md lists both.
std::string RefusalCode(const Error& error);

}  // namespace intaglio::client
