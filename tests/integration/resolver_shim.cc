// Preloaded into one process: nobody answers for the host never.example, for longer than
// a test takes. All other names are resolved as before.

#include <dlfcn.h>
#include <netdb.h>
#include <unistd.h>

#include <cstring>

extern "C" int getaddrinfo(const char* node, const char* service, const addrinfo* hints,
                           addrinfo** found) {
  constexpr unsigned kLong = 600;
  if (node != nullptr && std::strcmp(node, "never.example") == 0) {
    sleep(kLong);
    return EAI_AGAIN;
  }
  using Resolve = int (*)(const char*, const char*, const addrinfo*, addrinfo**);
  static const auto kResolve = reinterpret_cast<Resolve>(dlsym(RTLD_NEXT, "getaddrinfo"));
  return kResolve(node, service, hints, found);
}
