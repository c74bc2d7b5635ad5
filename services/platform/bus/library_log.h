#pragma once

namespace intaglio::bus {

/// What the DDS library has to say goes to the standard error stream, a line each and the
/// same line once a minute: a stranger who knocks twice a second should fill no disk.
/// What is said at every start and means nothing is left out: that somebody was heard
/// before this process had proved who it is; they find each other half a second later.
void KeepLibraryLogShort();

}  // namespace intaglio::bus
