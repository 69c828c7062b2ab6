/* Stands in for a file system without locks, when it is preloaded: flock fails with the error FLOCK_ERRNO. */
#include <errno.h>
#include <stdlib.h>

int flock(int descriptor, int operation) {
  const char* number = getenv("FLOCK_ERRNO");
  (void)descriptor;
  (void)operation;
  errno = number ? atoi(number) : ENOLCK;
  return -1;
}
