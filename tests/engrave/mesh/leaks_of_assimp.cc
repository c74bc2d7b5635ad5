// Assimp 5.2 does not free what it has read of a package or a scene once it finds the
// file damaged. The leak sanitizer is told; without it nobody calls this.
extern "C" const char* __lsan_default_suppressions();   // NOLINT: the sanitizer's name
extern "C" const char* __lsan_default_suppressions() {  // NOLINT
  return "leak:libassimp\n";
}
