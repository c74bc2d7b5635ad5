#pragma once

#include <cstdlib>
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace intaglio::host {

/// Gives freed memory back to the system. The library of C keeps up to 64 MB of freed
/// small blocks, such as the nodes of a tree, beside what is allocated next. Takes some
/// milliseconds: for use behind work on millions of points.
inline void ReturnFreedMemory() {
#ifdef __GLIBC__
  static_cast<void>(::malloc_trim(0));
#endif
}

}  // namespace intaglio::host
