// A library for LD_PRELOAD. Makes library functions fail, so that a CHECK fails or the program
// meets an unexpected error. Tests then see a real program's report of a bug.
#include <dlfcn.h>
#include <pthread.h>

#include <cerrno>
#include <cstdlib>
#include <string>

extern "C" {

/// Makes the start of SHA-256 fail, so no archive's digest can be computed.
int EVP_DigestInit_ex(void*, const void*, void*) {
  return 0;
}

/// If FAILING_THREADS is set, thread creation fails. The error is one that no user can fix.
int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*work)(void*),
                   void* argument) {
  if (std::getenv("FAILING_THREADS") != nullptr) return EPERM;
  using Function = int(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
  auto* const real = reinterpret_cast<Function*>(dlsym(RTLD_NEXT, "pthread_create"));
  return real(thread, attributes, work, argument);
}

/// On rank 1, reports that MPI doesn't support threads.
int MPI_Init_thread(int* argc, char*** argv, int required, int* provided) {
  using Function = int(int*, char***, int, int*);
  auto* const real = reinterpret_cast<Function*>(dlsym(RTLD_NEXT, "MPI_Init_thread"));
  const int outcome = real(argc, argv, required, provided);
  const char* const rank = std::getenv("OMPI_COMM_WORLD_RANK");
  if (rank != nullptr && std::string(rank) == "1") *provided = 0;
  return outcome;
}
}
