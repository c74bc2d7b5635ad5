// Assimp 5.2 does not free what it has read of a package or a scene once it finds the
// file damaged. The leak sanitizer calls this to suppress these reports; without the
// sanitizer it is unused.
extern "C" const char* __lsan_default_suppressions();   // NOLINT: the sanitizer's name
extern "C" const char* __lsan_default_suppressions() {  // NOLINT
  return "leak:libassimp\n";
}
