#pragma once

// Objects of C libraries in std::unique_ptr: the deleter calls the library's function.

namespace intaglio::drawing {

template <auto Done>
struct Closer {
  template <typename T>
  void operator()(T* object) const {
    Done(object);
  }
};

}  // namespace intaglio::drawing
