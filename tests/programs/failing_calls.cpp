// For LD_PRELOAD: outside functions that fail where the programs CHECK that they don't, or expect
// nothing of the kind, so that a test sees what a real program says of a bug. The programs
// themselves have no way to be made fail.
#include <dlfcn.h>
#include <pthread.h>

#include <cerrno>
#include <cstdlib>
#include <string>

extern "C" {

/// SHA-256 can't be begun: the digest of an archive can't be computed.
int EVP_DigestInit_ex(void*, const void*, void*) {
  return 0;
}

/// With FAILING_THREADS set no thread may be made, for a reason that nobody can mend.
int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*work)(void*),
                   void* argument) {
  if (std::getenv("FAILING_THREADS") != nullptr) return EPERM;
  using Function = int(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
  auto* const real = reinterpret_cast<Function*>(dlsym(RTLD_NEXT, "pthread_create"));
  return real(thread, attributes, work, argument);
}

/// On rank 1 MPI provides less than is asked for.
int MPI_Init_thread(int* argc, char*** argv, int required, int* provided) {
  using Function = int(int*, char***, int, int*);
  auto* const real = reinterpret_cast<Function*>(dlsym(RTLD_NEXT, "MPI_Init_thread"));
  const int outcome = real(argc, argv, required, provided);
  const char* const rank = std::getenv("OMPI_COMM_WORLD_RANK");
  if (rank != nullptr && std::string(rank) == "1") *provided = 0;
  return outcome;
}
}
