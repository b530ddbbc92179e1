/* Options of the sanitizers for `make check-san`, compiled twice: into each
 * sanitized program, which must not leak, and (TALUS_PRELOAD) as a library that
 * is preloaded into Python, which does. A program's own definition comes before
 * the preloaded one, the preloaded one before the sanitizer's, whose check that
 * nothing stands before it is therefore off. A finding ends with status 99, which
 * no program of ours answers, so that no test can take it for an expected failure. */
#ifdef TALUS_PRELOAD
#define LEAKS "detect_leaks=0:verify_asan_link_order=0"
#else
#define LEAKS "detect_leaks=1:verify_asan_link_order=0"
#endif

const char *__asan_default_options(void);
const char *__ubsan_default_options(void);
const char *__lsan_default_options(void);

const char *__asan_default_options(void) {
  return "exitcode=99:strict_string_checks=1:" LEAKS;
}

const char *__ubsan_default_options(void) {
  return "exitcode=99:print_stacktrace=1";
}

const char *__lsan_default_options(void) {
  return "exitcode=99";
}
