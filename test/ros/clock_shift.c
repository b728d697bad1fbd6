/*
 * Steps the system clock of who preloads it, as a time service does: by the seconds (a 64-bit number) in the file
 * $CLOCK_SHIFT_FILE, at once. Steady clocks stay. Waits until a time of the system clock follow, as the kernel's do;
 * only those under way at the step do not. With WITHOUT_WAITS none does, which no step of a real clock brings about.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/time.h>
#include <time.h>

/* A later time than any steady clock shows, and an earlier one than any system clock. */
#define SYSTEM_TIME 1000000000

static int64_t shift_s(void) {
  static volatile int64_t *shared;
  if (!shared) {
    const char *path = getenv("CLOCK_SHIFT_FILE");
    int file = path ? open(path, O_RDONLY | O_CLOEXEC) : -1;
    void *mapped = file < 0 ? MAP_FAILED : mmap(NULL, sizeof *shared, PROT_READ, MAP_SHARED, file, 0);
    if (mapped == MAP_FAILED) return 0;
    shared = mapped;
  }
  return *shared;
}

static void *next(const char *name) {
  void *found = dlvsym(RTLD_NEXT, name, "GLIBC_2.3.2"); /* the older conditions of x86-64 are others */
  return found ? found : dlsym(RTLD_NEXT, name);
}

int clock_gettime(clockid_t clock, struct timespec *now) {
  static int (*real)(clockid_t, struct timespec *);
  if (!real) real = (int (*)(clockid_t, struct timespec *))next("clock_gettime");
  int result = real(clock, now);
  if (!result && (clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE)) now->tv_sec += shift_s();
  return result;
}

int gettimeofday(struct timeval *restrict now, void *restrict zone) {
  struct timespec precise;
  (void)zone;
  clock_gettime(CLOCK_REALTIME, &precise);
  now->tv_sec = precise.tv_sec;
  now->tv_usec = precise.tv_nsec / 1000;
  return 0;
}

time_t time(time_t *result) {
  struct timespec precise;
  clock_gettime(CLOCK_REALTIME, &precise);
  if (result) *result = precise.tv_sec;
  return precise.tv_sec;
}

#ifndef WITHOUT_WAITS
static struct timespec real_time(const struct timespec *deadline) {
  struct timespec result = *deadline;
  if (result.tv_sec > SYSTEM_TIME) result.tv_sec -= shift_s();
  return result;
}

int pthread_cond_timedwait(pthread_cond_t *condition, pthread_mutex_t *mutex, const struct timespec *deadline) {
  static int (*real)(pthread_cond_t *, pthread_mutex_t *, const struct timespec *);
  if (!real) real = (int (*)(pthread_cond_t *, pthread_mutex_t *, const struct timespec *))next("pthread_cond_timedwait");
  struct timespec shifted = real_time(deadline);
  return real(condition, mutex, &shifted);
}

int pthread_mutex_timedlock(pthread_mutex_t *mutex, const struct timespec *deadline) {
  static int (*real)(pthread_mutex_t *, const struct timespec *);
  if (!real) real = (int (*)(pthread_mutex_t *, const struct timespec *))next("pthread_mutex_timedlock");
  struct timespec shifted = real_time(deadline);
  return real(mutex, &shifted);
}

int sem_timedwait(sem_t *semaphore, const struct timespec *deadline) {
  static int (*real)(sem_t *, const struct timespec *);
  if (!real) real = (int (*)(sem_t *, const struct timespec *))next("sem_timedwait");
  struct timespec shifted = real_time(deadline);
  return real(semaphore, &shifted);
}
#endif
