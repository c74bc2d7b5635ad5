#pragma once

namespace intaglio::bus {

/// Messages of the DDS library go to the standard error stream, a line each and the same
/// line at most once a minute: a stranger who tries to join twice a second should not
/// fill a disk. The message that appears at every start and means nothing is left out:
/// that a participant was discovered before this process had proved its own identity; the
/// two find each other half a second later.
void KeepLibraryLogShort();

}  // namespace intaglio::bus
