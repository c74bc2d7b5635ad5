// Preloaded into one process: its wall clock is off by the seconds that are in the file
// of INTAGLIO_CLOCK_OFFSET, eight bytes, which the test changes while the process runs.
// As with a clock that is set, waits that have an end by the wall clock end by the new
// time.

#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>

namespace {

const std::atomic<long>* MapOffset() {
  static const std::atomic<long> none{0};
  const char* file = std::getenv("INTAGLIO_CLOCK_OFFSET");
  const int handle = file == nullptr ? -1 : open(file, O_RDONLY | O_CLOEXEC);
  if (handle < 0) return &none;
  void* at = mmap(nullptr, sizeof(long), PROT_READ, MAP_SHARED, handle, 0);
  close(handle);
  return at == MAP_FAILED ? &none : static_cast<const std::atomic<long>*>(at);
}

long Offset() {
  static const std::atomic<long>* offset = MapOffset();
  return *offset;
}

constexpr long kNano = 1'000'000'000, kSlice = 20'000'000;

bool IsBefore(const timespec& a, const timespec& b) {
  return a.tv_sec < b.tv_sec || (a.tv_sec == b.tv_sec && a.tv_nsec < b.tv_nsec);
}

}  // namespace

extern "C" {

int clock_gettime(clockid_t which, timespec* result) noexcept {
  const long error = syscall(SYS_clock_gettime, which, result);
  if (error == 0 && (which == CLOCK_REALTIME || which == CLOCK_REALTIME_COARSE)) {
    result->tv_sec += Offset();
  }
  return static_cast<int>(error);
}

int gettimeofday(timeval* result, void*) noexcept {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  *result = {now.tv_sec, now.tv_nsec / 1000};
  return 0;
}

time_t time(time_t* result) noexcept {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  if (result != nullptr) *result = now.tv_sec;
  return now.tv_sec;
}

int pthread_cond_timedwait(pthread_cond_t* condition, pthread_mutex_t* mutex,
                           const timespec* end) {
  using Wait = int (*)(pthread_cond_t*, pthread_mutex_t*, const timespec*);
  static const Wait wait =
      reinterpret_cast<Wait>(dlvsym(RTLD_NEXT, "pthread_cond_timedwait", "GLIBC_2.3.2"));
  for (;;) {
    timespec now{};
    clock_gettime(CLOCK_REALTIME, &now);
    if (!IsBefore(now, *end)) return ETIMEDOUT;
    timespec slice = now;
    slice.tv_nsec += kSlice;
    slice.tv_sec += slice.tv_nsec / kNano;
    slice.tv_nsec %= kNano;
    if (IsBefore(*end, slice)) slice = *end;
    slice.tv_sec -= Offset();
    if (const int result = wait(condition, mutex, &slice); result != ETIMEDOUT)
      return result;
  }
}

}  // extern "C"
